"""Ways of a map: the centre lines that lead on to each other through the lane sections of a road."""

import numpy as np
import shapely

from gpsec.arrays import Floats
from gpsec.opendrive.lanes import CentreLine, paths
from gpsec.opendrive.polylines import spread, stations

# How far beside a way a path through a junction may begin and end, and how far before its beginning or behind its end:
# SUMO's junctions reach into the roads.
_BESIDE_M, _BEFORE_M = 1.0, 20.0
# A lane further from where it should be is not moved there.
_MOVED_M = 8.0
_CLOSEST_M = 0.2
_SAME_PLACE_M = 1e-3
_TANGENT_M = 0.5


class Ways:
    """The ways of a map through its roads, by the lanes that they run over."""

    def __init__(self, lines: list[CentreLine]) -> None:
        self._lanes: dict[str, list[tuple[shapely.LineString, shapely.LineString]]] = {}
        for path in paths(lines):
            points = spread(np.concatenate([line.points_m for line in path]), _SAME_PLACE_M)
            if stations(points)[-1] > _CLOSEST_M:
                way = shapely.LineString(points)
                for line in path:
                    lane = shapely.LineString(line.points_m)
                    self._lanes.setdefault(f"{line.road_id}_{line.lane_id}", []).append((lane, way))

    def beside(self, name: str, shape: Floats) -> Floats | None:
        """Return the piece of the way over lane `name` that lies beside a shape; None where none does.

        Sections of a road may use one number for lanes that are not the same: the nearest section counts.
        """
        ends = stations(shape)
        middle = shapely.Point([np.interp(0.5 * ends[-1], ends, shape[:, axis]) for axis in (0, 1)])
        found = [(float(lane.distance(middle)), way) for lane, way in self._lanes.get(name, [])]
        away, way = min(found, key=lambda item: item[0], default=(np.inf, None))
        if way is None or away > _MOVED_M:
            return None
        begin, finish = (float(way.project(shapely.Point(point))) for point in (shape[0], shape[-1]))
        if finish - begin < _SAME_PLACE_M:
            return None
        start, end = (shapely.get_coordinates(way.interpolate(place))[0] for place in (begin, finish))
        return _piece(way, begin, finish, start, end)

    def between(self, name: str, start: Floats, end: Floats) -> Floats | None:
        """Return the points from `start` to `end` along the way over lane `name` that fits them best.

        None where there is no way from the one to the other.
        """
        fits = [(*_fit(way, start, end), way) for _, way in self._lanes.get(name, [])]
        off, begin, finish, way = min(fits, key=lambda item: item[0], default=(np.inf, 0.0, 0.0, None))
        if way is None or off > _BESIDE_M or finish <= begin:
            return None
        return _piece(way, begin, finish, start, end)


def _piece(way: shapely.LineString, begin: float, finish: float, start: Floats, end: Floats) -> Floats:
    """Return `start`, the points of a way between two places along it, and `end`."""
    points = shapely.get_coordinates(way)
    place = stations(points)
    inside = points[(place > begin + _CLOSEST_M) & (place < finish - _CLOSEST_M)]
    return spread([start, *inside, end], _CLOSEST_M)


def _fit(way: shapely.LineString, start: Floats, end: Floats) -> tuple[float, float, float]:
    """Return how far beside a way two points lie, infinite where they lie too far before or behind it, and where."""
    begin, finish = (float(way.project(shapely.Point(point))) for point in (start, end))
    worst = 0.0
    for place, point in ((begin, start), (finish, end)):
        low, foot, high = (
            shapely.get_coordinates(way.interpolate(float(np.clip(at, 0.0, way.length))))[0]
            for at in (place - _TANGENT_M, place, place + _TANGENT_M)
        )
        ahead = (high - low) / np.hypot(*(high - low))
        off = point - foot
        beside = abs(ahead[0] * off[1] - ahead[1] * off[0])
        worst = max(worst, beside if abs(ahead @ off) <= _BEFORE_M else np.inf)
    return float(worst), begin, finish
