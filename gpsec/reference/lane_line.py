"""One lane's centre line, and how a position lies beside it."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
import shapely

from gpsec.core.arrays import Floats
from gpsec.hdmap.map import HDMap
from gpsec.reference.filters import wrapped
from gpsec.reference.matching import point_yaw


@dataclass(frozen=True)
class Beside:
    """A position beside a lane.

    Attributes:
        offset_m: d1 of Eq 6, left positive.
        turn_rad: the lane's direction less the heading.
        left: (2,) unit vector to the left of the lane.
        curvature_per_m: of the lane.
    """

    offset_m: float
    turn_rad: float
    left: Floats
    curvature_per_m: float


@dataclass(frozen=True, eq=False)
class LaneLine:
    """A lane as a vehicle's map has it: n segments.

    Attributes:
        start_m: (n, 2) first points; direction: (n, 2) unit vectors; length_m: (n,).
        yaw_rad: (n + 1,) of the lane at its points; curvature_per_m: (n, 2) at both ends of each segment.
    """

    start_m: Floats
    direction: Floats
    length_m: Floats
    yaw_rad: Floats
    curvature_per_m: Floats

    @staticmethod
    def of(hd_map: HDMap, lane: int, layer: int) -> "LaneLine":
        """Return a lane of a map's layer."""
        points = hd_map.centre_line(lane, layer)
        way = np.diff(points, axis=0)
        length = np.hypot(way[:, 0], way[:, 1])
        first = hd_map.lanes.first[layer, lane]
        run = slice(first, first + len(way))
        ends = [hd_map.lanes.curvature0_per_m[run], hd_map.lanes.curvature1_per_m[run]]
        return LaneLine(points[:-1], way / length[:, None], length, point_yaw(points), np.stack(ends, axis=1))

    def along(self, segment: int, position_m: Floats) -> float:
        """Return how far along a segment a position lies, in metres."""
        return float(self.direction[segment] @ (position_m - self.start_m[segment]))

    def beside(self, segment: int, position_m: Floats, heading_rad: float) -> Beside:
        """Return how a position lies beside a segment, which goes straight on past its ends."""
        share = min(max(self.along(segment, position_m) / float(self.length_m[segment]), 0.0), 1.0)
        yaw = (1.0 - share) * self.yaw_rad[segment] + share * self.yaw_rad[segment + 1]
        turn = wrapped(float(yaw) - heading_rad)
        left = np.array([-self.direction[segment, 1], self.direction[segment, 0]])
        offset = float(left @ (position_m - self.start_m[segment])) / max(cos(turn), 1e-3)
        curvature = (1.0 - share) * self.curvature_per_m[segment, 0] + share * self.curvature_per_m[segment, 1]
        return Beside(offset, turn, left, float(curvature))

    def walk(self, segment: int, position_m: Floats) -> tuple[int, bool]:
        """Return the segment beside a position, going on from `segment`, and whether the end is passed."""
        last = len(self.length_m) - 1
        for _ in range(12):
            along = self.along(segment, position_m)
            if along > self.length_m[segment]:
                if segment == last:
                    return segment, True
                segment += 1
            elif along < 0.0 and segment > 0:
                if self.along(segment - 1, position_m) > self.length_m[segment - 1]:
                    return segment, False
                segment -= 1
            else:
                return segment, False
        return segment, False

    def _distances(self, position_m: Floats) -> Floats:
        ends = self.start_m + self.direction * self.length_m[:, None]
        lines = shapely.linestrings(np.stack([self.start_m, ends], axis=1))
        return np.asarray(shapely.distance(lines, shapely.Point(*position_m)))

    def within(self, position_m: Floats, heading_rad: float, reach_m: float) -> list[tuple[int, float]]:
        """Return the segments within reach that lead the vehicle's way to within 60°, with their distances."""
        distance = self._distances(position_m)
        ahead = self.direction @ (cos(heading_rad), sin(heading_rad)) >= 0.5
        return [(int(one), float(distance[one])) for one in np.flatnonzero(ahead & (distance <= reach_m))]

    def nearest(self, position_m: Floats, heading_rad: float) -> int | None:
        """Return the nearest segment that leads the vehicle's way, None where none does."""
        ahead = np.flatnonzero(self.direction @ (cos(heading_rad), sin(heading_rad)) >= 0.0)
        if not len(ahead):
            return None
        return int(ahead[np.argmin(self._distances(position_m)[ahead])])


class LaneLines:
    """The lanes of one layer of a map, made when they are asked for.

    Attributes:
        hd_map: the map.
    """

    def __init__(self, hd_map: HDMap, layer: int) -> None:
        self.hd_map = hd_map
        self._layer = layer
        self._made: dict[int, LaneLine] = {}

    def __getitem__(self, lane: int) -> LaneLine:
        """Return a lane by its index."""
        if lane not in self._made:
            self._made[lane] = LaneLine.of(self.hd_map, lane, self._layer)
        return self._made[lane]

    def __deepcopy__(self, memo: object) -> "LaneLines":
        """Return itself: tracks that fork go on with one map."""
        return self
