"""What is on the ground: the roads' surface, the paint of lane boundaries, and what may be taken for it.

The paint is not the map: each line is off by a smooth error of its own, and worn here more than there. Both come from
a hash of the line's name.
"""

from math import pi, sqrt

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.noise import vehicle_key
from gpsec.hdmap.map import HDMap
from gpsec.hdmap.polyline import Polyline, measure, resample
from gpsec.imaging.pictures.strips import Painted, join_strips

SURFACE, WHITE_PAINT, YELLOW_PAINT, SEAM, SHADE = range(5)
"""Kinds of strips."""
# Manual on Uniform Traffic Control Devices, 3A.06: lines of 4 to 6 inches, dashes of 10 feet with gaps of 30 feet.
_PAINT_M, _DASH_M, _PERIOD_M = 0.15, 3.05, 12.19
# The same, 3B.16: stop lines of 12 to 24 inches.
_STOP_M = 0.45
# Assumed: the surface goes on beyond the edge lines.
_SHOULDER_M = 0.8
PAINT_ERROR_M = 0.015
"""Standard deviation of the error of a line across the road (assumed: what survey and paint machine leave)."""
# Of the error, longer than the view less so: waves along the line.
_WAVES_M = (23.0, 41.0, 78.0, 150.0)
# Assumed: so often there is a repaired crack, or a tree beside the road.
_SEAM_EVERY_M, _TREE_EVERY_M = 60.0, 35.0
_STEP_M = 1.0
# A junction whose lanes turn less joins roads or parts them, and nothing has to be stopped for.
_TURN = 0.5

_Piece = tuple[Floats, Floats, int, Floats]


def paint_roads(hd_map: HDMap, seed: int) -> Painted:
    """Return the ground of a net; `seed` makes its errors and its wear."""
    pieces: list[_Piece] = []
    for lane in range(len(hd_map.lane_ids)):
        line = resample(measure(hd_map.centre_line(lane)), _STEP_M)
        width_m = float(hd_map.sides.width_m[lane])
        pieces.append(_band(line, 0.0, width_m + 2.0 * _SHOULDER_M, SURFACE))
        if not hd_map.sides.internal[lane]:
            pieces += _boundaries(hd_map, lane, line, seed)
            pieces += _clutter(hd_map.lane_ids[lane], line, width_m, seed)
    pieces.sort(key=lambda piece: piece[2])
    return Painted.of(join_strips(pieces))


def _boundaries(hd_map: HDMap, lane: int, line: Polyline, seed: int) -> list[_Piece]:
    """Return the paint of a lane: its left boundary, its right one where it is the edge, and its stop line."""
    name, half_m = hd_map.lane_ids[lane], 0.5 * float(hd_map.sides.width_m[lane])
    left, right = int(hd_map.graph.left[lane]), int(hd_map.graph.right[lane])
    found = []
    if left < 0:
        found.append(_line(line, half_m, YELLOW_PAINT, vehicle_key(seed, f"{name} left")))
    else:
        # The dashes of an edge are in step with each other, as the same machine paints them.
        found += _dashes(line, half_m, vehicle_key(seed, f"{name} left"), hd_map.lane_ids[lane].rpartition("_")[0])
    if right < 0:
        found.append(_line(line, -half_m, WHITE_PAINT, vehicle_key(seed, f"{name} right")))
    if _leads_into_turns(hd_map, lane):
        found.append(_stop_line(line, half_m))
    return found


def _line(line: Polyline, offset_m: float, kind: int, key: int) -> _Piece:
    left, right, _, _ = _band(line, offset_m + _error(line.s_m, key), _PAINT_M, kind)
    return left, right, kind, _wear(line.s_m, key)


def _dashes(line: Polyline, offset_m: float, key: int, edge: str) -> list[_Piece]:
    left, right, _, wear = _line(line, offset_m, WHITE_PAINT, key)
    length_m = line.s_m[-1]
    first = -(vehicle_key(0, edge) % 1000) / 1000.0 * _PERIOD_M
    found = []
    for start in np.arange(first, length_m, _PERIOD_M):
        a, b = max(start, 0.0), min(start + _DASH_M, length_m)
        if b - a > 0.3:
            s = np.array([a, *line.s_m[(line.s_m > a + 0.05) & (line.s_m < b - 0.05)], b])
            ends = [
                np.stack([np.interp(s, line.s_m, side[:, axis]) for axis in (0, 1)], axis=1) for side in (left, right)
            ]
            found.append((ends[0], ends[1], WHITE_PAINT, np.interp(s, line.s_m, wear)))
    return found


def _at(line: Polyline, side_m: Floats, s_m: Floats) -> Floats:
    """Return (m, 2) points of a side (n, 2) of a line at (m,) arc lengths."""
    return np.stack([np.interp(s_m, line.s_m, side_m[:, axis]) for axis in (0, 1)], axis=1)


def _stop_line(line: Polyline, half_m: float) -> _Piece:
    end, yaw = line.points_m[-1], line.yaw_rad[-1]
    ahead, across = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    middle = np.stack([end - 1.0 * ahead - _STOP_M * ahead, end - 1.0 * ahead])
    return middle + half_m * across, middle - half_m * across, WHITE_PAINT, np.full(2, 0.3)


def _clutter(name: str, line: Polyline, width_m: float, seed: int) -> list[_Piece]:
    """Return what may be taken for paint: tar in cracks along the lane, and shadows of trees across it."""
    draw = np.random.default_rng(vehicle_key(seed, f"{name} clutter"))
    length_m = float(line.s_m[-1])
    found = []
    for s in np.sort(draw.uniform(0.0, length_m, draw.poisson(length_m / _SEAM_EVERY_M))):
        offset_m, turn, long_m = draw.uniform(-0.45, 0.45) * width_m, draw.normal(0.0, 0.01), draw.uniform(3.0, 15.0)
        part = _part(line, s, s + long_m)
        if part is not None:
            found.append(_band(part, offset_m + turn * part.s_m, draw.uniform(0.03, 0.08), SEAM))
    for s in np.sort(draw.uniform(0.0, length_m, draw.poisson(length_m / _TREE_EVERY_M))):
        part = _part(line, s, s + draw.uniform(3.0, 9.0))
        if part is not None:
            sway = np.cumsum(draw.normal(0.0, 0.5, len(part.s_m)))
            found.append(_band(part, sway - draw.uniform(0.0, 2.0), draw.uniform(0.3, 1.4) * width_m, SHADE))
    return found


def _part(line: Polyline, from_m: float, to_m: float) -> Polyline | None:
    """Return the points of a line from one arc length to another, None where there is no line left."""
    inside = (line.s_m >= from_m) & (line.s_m <= to_m)
    return measure(line.points_m[inside]) if inside.sum() > 1 else None


def _band(line: Polyline, offset_m: float | Floats, width_m: float, kind: int) -> _Piece:
    """Return a strip of that width, whose middle lies `offset_m` left of a line."""
    across = np.stack([-np.sin(line.yaw_rad), np.cos(line.yaw_rad)], axis=1)
    middle = line.points_m + np.reshape(offset_m, (-1, 1)) * across
    return middle + 0.5 * width_m * across, middle - 0.5 * width_m * across, kind, np.zeros(len(line.s_m))


def _error(s_m: Floats, key: int) -> Floats:
    """Return the error of a line at (n,) arc lengths."""
    phase = np.random.default_rng(key).uniform(0.0, 2.0 * pi, len(_WAVES_M))
    waves = np.cos(2.0 * pi * s_m[:, None] / np.array(_WAVES_M) + phase)
    error: Floats = PAINT_ERROR_M * sqrt(2.0 / len(_WAVES_M)) * waves.sum(axis=1)
    return error


def _wear(s_m: Floats, key: int) -> Floats:
    """Return how soon a line is worn off at (n,) arc lengths, uniform on 0 … 1 and alike within some metres."""
    draw = np.random.default_rng([key, 1])
    places = np.arange(int(s_m[-1] / 2.5) + 2) * 2.5
    # The worn stretches of a line are long: a slow part, such as where the wheels of a curve cross it, and a quick one.
    slow = np.interp(places, places[::8], draw.uniform(size=len(places[::8])))
    worn: Floats = np.interp(s_m, places, 0.5 * slow + 0.5 * draw.uniform(size=len(places)))
    return worn


def _leads_into_turns(hd_map: HDMap, lane: int) -> bool:
    """Return whether a lane, or one beside it, leads into a junction in which one can turn off."""
    beside = [lane]
    for way in (hd_map.graph.left, hd_map.graph.right):
        other = int(way[lane])
        while other >= 0:
            beside.append(other)
            other = int(way[other])
    return any(
        hd_map.sides.internal[after] and _turn(hd_map, after) > _TURN for one in beside for after in _after(hd_map, one)
    )


def _after(hd_map: HDMap, lane: int) -> list[int]:
    first, count = hd_map.graph.after_first[lane], hd_map.graph.after_count[lane]
    after: list[int] = hd_map.graph.after_lane[first : first + count].tolist()
    return after


def _turn(hd_map: HDMap, lane: int) -> float:
    first = hd_map.lanes.first[0, lane]
    return abs(float(hd_map.lanes.turn_rad[first : first + hd_map.lanes.segments[0, lane]].sum()))
