"""Map matching by shapely: the nearest lane segment, and the signed offset from it (Eqs 2-6)."""

from math import cos, inf, pi, sin
from typing import NamedTuple

import numpy as np
import shapely

from gpsec.core.arrays import Floats, Ints
from gpsec.hdmap.map import HDMap
from gpsec.localization.sparse_map import DIRECTION_SHARE, OFFSET_SHARE

# Segments that are equally near to within this count as such; the first of them in the map is taken.
TIE_M = 1e-11
# Eq 6 holds up to this angle between heading and lane.
WIDEST_ANGLE_COS = 0.5
# How far straight on a lane is continued where nothing is joined to its end.
_EXTENSION_M = 1000.0
# Nearest matching looks this far, in steps that grow.
_RADII_M = (4.0, 16.0, 64.0)


class OnLane(NamedTuple):
    """The lane that a position is matched to, and the offset from its centre, left positive."""

    lane: int
    offset_m: float


class LaneMatcher:
    """The lanes as a vehicle's own map has them, one shapely line for each segment.

    Attributes:
        tracked: match to the lane that is believed, with what leads to it and on from it; else to the nearest.

    """

    def __init__(self, hd_map: HDMap, layer: int, tracked: bool) -> None:
        self.tracked = tracked
        self._hd_map = hd_map
        lines = [hd_map.centre_line(lane, layer) for lane in range(len(hd_map.lane_ids))]
        count = [len(line) - 1 for line in lines]
        self._first = np.concatenate([[0], np.cumsum(count)])
        self._start_m: Floats = np.concatenate([line[:-1] for line in lines])
        self._end_m: Floats = np.concatenate([line[1:] for line in lines])
        yaws = [point_yaw(line) for line in lines]
        self._start_yaw_rad: Floats = np.concatenate([yaw[:-1] for yaw in yaws])
        self._end_yaw_rad: Floats = np.concatenate([yaw[1:] for yaw in yaws])
        self._open_start = np.zeros(len(self._start_m), np.bool_)
        self._open_end = np.zeros(len(self._start_m), np.bool_)
        if tracked:
            begin, ends = self._first[:-1], self._first[1:] - 1
            offset = hd_map.lanes.first[layer, 0]
            self._open_start[begin] = hd_map.lanes.open_start[offset + begin]
            self._open_end[ends] = hd_map.lanes.open_end[offset + ends]
        way_m = self._end_m - self._start_m
        self._direction: Floats = way_m / np.hypot(way_m[:, :1], way_m[:, 1:])
        line_start = self._start_m - _EXTENSION_M * self._direction * self._open_start[:, None]
        line_end = self._end_m + _EXTENSION_M * self._direction * self._open_end[:, None]
        self._lines = shapely.linestrings(np.stack([line_start, line_end], axis=1))
        self._trees: dict[int, tuple[shapely.STRtree, Ints]] = {}

    def offset(self, x_m: float, y_m: float, heading_rad: float, lane: int) -> float | None:
        """Return the offset of a position from the lane centre, left positive; None where nothing matches."""
        found = self.match(x_m, y_m, heading_rad, lane)
        return None if found is None else found.offset_m

    def match(self, x_m: float, y_m: float, heading_rad: float, lane: int) -> OnLane | None:
        """Return the lane that a position is matched to, and its offset from that; None where nothing matches."""
        found = self._beside(x_m, y_m, heading_rad, lane)
        if found is None:
            return None
        return OnLane(int(np.searchsorted(self._first, found[2], side="right")) - 1, found[0])

    def view(self, x_m: float, y_m: float, heading_rad: float, lane: int) -> tuple[float, float] | None:
        """Return the offset from the arc over the matched segment, and the direction of the lane less the heading."""
        found = self._beside(x_m, y_m, heading_rad, lane)
        if found is None:
            return None
        offset, turn, segment = found
        first, last = self._start_yaw_rad[segment], self._end_yaw_rad[segment]
        share = float((turn + heading_rad - first) / (last - first)) if last != first else 0.0
        length = float(np.hypot(*(self._end_m[segment] - self._start_m[segment])))
        # The parabola that turns by as much as the lane does between the two points.
        return offset + (last - first) * length * share * (1.0 - share) / 2.0 / cos(turn), turn

    def unsure(self, x_m: float, y_m: float, heading_rad: float, lane: int, way_m: float) -> tuple[float, float]:
        """Return the variances of offset and direction by what the map leaves open, for a sample every `way_m`."""
        found = self._beside(x_m, y_m, heading_rad, lane)
        if found is None:
            return 0.0, 0.0
        segment = found[2]
        chord = self._end_m[segment] - self._start_m[segment]
        length, course = float(np.hypot(*chord)), float(np.arctan2(chord[1], chord[0]))
        first, last = self._start_yaw_rad[segment], self._end_yaw_rad[segment]
        if segment in self._first or segment + 1 in self._first:
            # The end of a lane: its direction is drawn on, and the curvature may end here.
            kinks = float(last - first)
        else:
            kinks = 2.0 * float((first + last - 2.0 * course + 2.0 * pi) % (4.0 * pi) - 2.0 * pi)
        samples = max(length / way_m, 1.0)
        return samples * (OFFSET_SHARE * kinks * length) ** 2, samples * (DIRECTION_SHARE * kinks) ** 2

    def _beside(self, x_m: float, y_m: float, heading_rad: float, lane: int) -> tuple[float, float, int] | None:
        point = shapely.Point(x_m, y_m)
        segment = self._on_chain(point, heading_rad, lane) if self.tracked else self._nearest(point, heading_rad)
        if segment is None:
            return None
        turn = self._yaw(segment, point) - heading_rad
        cosine = cos(turn)
        if abs(cosine) < WIDEST_ANGLE_COS:
            return None
        along, across = self._end_m[segment] - self._start_m[segment], (x_m, y_m) - self._start_m[segment]
        left = along[0] * across[1] - along[1] * across[0] >= 0.0
        distance = float(shapely.distance(self._lines[segment], point))
        return (distance if left else -distance) / cosine, turn, segment

    def _on_chain(self, point: shapely.Point, heading_rad: float, lane: int) -> int | None:
        """Return the nearest segment of a chain that leads the vehicle's way."""
        _, segments = self._tree(lane)
        ahead = segments[self._direction[segments] @ (cos(heading_rad), sin(heading_rad)) >= 0.0]
        if not len(ahead):
            return None
        distance = shapely.distance(self._lines[ahead], point)
        return int(ahead[distance <= distance.min() + TIE_M].min())

    def _nearest(self, point: shapely.Point, heading_rad: float) -> int | None:
        tree, _ = self._tree(-1)
        for radius_m in _RADII_M:
            near = np.sort(tree.query(point, predicate="dwithin", distance=radius_m))
            distance = shapely.distance(self._lines[near], point)
            best: int | None = None
            best_m = inf
            for segment, here_m in zip(near.tolist(), distance.tolist(), strict=True):
                if here_m < best_m - TIE_M:
                    cosine = cos(heading_rad - self._yaw(segment, point))
                    if cosine >= WIDEST_ANGLE_COS:
                        best, best_m = segment, here_m
            if best is not None:
                return best
        return None

    def _tree(self, lane: int) -> tuple[shapely.STRtree, Ints]:
        """Return the segments of a lane's chain, or of all lanes for -1, as a tree and their numbers."""
        if lane not in self._trees:
            index = self._hd_map.index
            run = slice(index.chain_first[lane], index.chain_first[lane] + index.chain_count[lane])
            members = range(len(self._first) - 1) if lane < 0 else sorted(index.chain_lane[run].tolist())
            segments = np.concatenate([np.arange(self._first[i], self._first[i + 1]) for i in members])
            self._trees[lane] = shapely.STRtree(self._lines[segments]), segments
        return self._trees[lane]

    def _yaw(self, segment: int, point: shapely.Point) -> float:
        """Return the direction of the lane beside a position, interpolated along the segment."""
        length = float(np.hypot(*(self._end_m[segment] - self._start_m[segment])))
        before = _EXTENSION_M if self._open_start[segment] else 0.0
        along = float(shapely.line_locate_point(self._lines[segment], point)) - before
        share = min(max(along / length, 0.0), 1.0)
        return float((1.0 - share) * self._start_yaw_rad[segment] + share * self._end_yaw_rad[segment])


def point_yaw(line_m: Floats) -> Floats:
    """Return the smoothed direction of a lane at each of its (n, 2) points.

    Within the lane it is the mean of the two segments that meet; at its ends, the direction of the last segment is
    carried on by half of the last turn.
    """
    step = np.diff(line_m, axis=0)
    course = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    if len(course) == 1:
        return np.repeat(course, 2)
    first = (3.0 * course[0] - course[1]) / 2.0
    last = (3.0 * course[-1] - course[-2]) / 2.0
    return np.concatenate([[first], (course[:-1] + course[1:]) / 2.0, [last]])
