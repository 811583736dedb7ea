"""Ways of a map: the centre lines that lead on to each other through the lane sections of a road."""

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from gpsec.core.arrays import Floats
from gpsec.opendrive.lanes import CentreLine, paths
from gpsec.opendrive.polylines import at_stations, spread, spread_out, stations

# How far beside a way a path through a junction may begin and end, and how far before its beginning or behind its end:
# SUMO's junctions reach into the roads.
_BESIDE_M, _BEFORE_M = 1.0, 20.0
# A lane further from where it should be is not moved there.
_MOVED_M = 8.0
_CLOSEST_M = 0.2
_SAME_PLACE_M = 1e-3
_TANGENT_M = 0.5


@dataclass(frozen=True)
class Way:
    """A way through a road, in driving order.

    Attributes:
        points_m: (n, 2).
        station_m: (n,) of the road, rising or falling.
    """

    points_m: Floats
    station_m: Floats

    @cached_property
    def along_m(self) -> Floats:
        """(n,) lengths along the way."""
        return stations(self.points_m)

    @cached_property
    def line(self) -> shapely.LineString:
        """The way as a line."""
        return shapely.LineString(self.points_m)

    @property
    def length_m(self) -> float:
        """Length of the way."""
        return float(self.along_m[-1])

    def along(self, station_m: float) -> float:
        """Return the length along the way at which a station of the road is reached."""
        sign = 1.0 if self.station_m[-1] >= self.station_m[0] else -1.0
        return float(np.interp(sign * station_m, sign * self.station_m, self.along_m))

    def station(self, point: Floats) -> float:
        """Return the station of the place on the way that is nearest to a point."""
        return float(np.interp(self.line.project(shapely.Point(point)), self.along_m, self.station_m))

    def piece(self, begin_m: float, finish_m: float) -> Floats:
        """Return the (n, 2) points between two lengths along the way."""
        start, end = at_stations(self.points_m, np.array([begin_m, finish_m]))
        return self.between(start, end, begin_m, finish_m)

    def between(self, start: Floats, end: Floats, begin_m: float, finish_m: float) -> Floats:
        """Return `start`, the points of the way between two lengths along it, and `end`."""
        inside = self.points_m[(self.along_m > begin_m + _CLOSEST_M) & (self.along_m < finish_m - _CLOSEST_M)]
        return spread([start, *inside, end], _CLOSEST_M)


@dataclass(frozen=True)
class WayPiece:
    """The piece of a way over one lane of one lane section."""

    way: Way
    line: shapely.LineString
    low_m: float
    high_m: float


class Ways:
    """The ways of a map through its roads, by the lanes that they run over ("road_lane")."""

    def __init__(self, lines: list[CentreLine]) -> None:
        self._parts: dict[str, list[WayPiece]] = {}
        for path in paths(lines):
            points = np.concatenate([line.points_m for line in path])
            kept = spread_out(points, _SAME_PLACE_M)
            way = Way(points[kept], np.concatenate([line.station_m for line in path])[kept])
            if way.length_m > _CLOSEST_M:
                for line in path:
                    ends = sorted((float(line.station_m[0]), float(line.station_m[-1])))
                    part = WayPiece(way, shapely.LineString(line.points_m), *ends)
                    self._parts.setdefault(f"{line.road_id}_{line.lane_id}", []).append(part)

    def beside(self, name: str, shape: Floats) -> WayPiece | None:
        """Return the part of lane `name` that lies beside a shape, None where none does.

        Sections of a road may use one number for lanes that are not the same: the nearest section counts.
        """
        middle = shapely.Point(at_stations(shape, stations(shape)[-1:] * 0.5)[0])
        found = [(float(part.line.distance(middle)), part) for part in self._parts.get(name, [])]
        away, part = min(found, key=lambda item: item[0], default=(np.inf, None))
        return part if away <= _MOVED_M else None

    def over(self, name: str, station_m: float) -> Way | None:
        """Return the way over lane `name` at a station of its road, None where there is none."""
        return next((part.way for part in self._parts.get(name, []) if part.low_m <= station_m <= part.high_m), None)

    def named(self, name: str) -> list[Way]:
        """Return the ways over lane `name`, in any section."""
        return [part.way for part in self._parts.get(name, [])]

    def between(self, name: str, start: Floats, end: Floats) -> Floats | None:
        """Return the points from `start` to `end` along the way over lane `name` that fits them best.

        None where there is no way from the one to the other.
        """
        fits = [(*_fit(way, start, end), way) for way in self.named(name)]
        off, begin, finish, way = min(fits, key=lambda item: item[0], default=(np.inf, 0.0, 0.0, None))
        if way is None or off > _BESIDE_M or finish <= begin:
            return None
        return way.between(start, end, begin, finish)


def joined(pieces: list[Floats]) -> Floats | None:
    """Return pieces of ways as one line, None where the end of one is not the beginning of the next."""
    for before, behind in itertools.pairwise(pieces):
        if np.hypot(*(behind[0] - before[-1])) > _BESIDE_M:
            return None
    return spread(np.concatenate(pieces), _CLOSEST_M)


def _fit(way: Way, start: Floats, end: Floats) -> tuple[float, float, float]:
    """Return how far beside a way two points lie, infinite where they lie too far before or behind it, and where."""
    begin, finish = (float(way.line.project(shapely.Point(point))) for point in (start, end))
    worst = 0.0
    for place, point in ((begin, start), (finish, end)):
        tangent = np.clip([place - _TANGENT_M, place, place + _TANGENT_M], 0.0, way.length_m)
        low, foot, high = at_stations(way.points_m, tangent)
        ahead = (high - low) / np.hypot(*(high - low))
        off = point - foot
        beside = abs(ahead[0] * off[1] - ahead[1] * off[0])
        worst = max(worst, beside if abs(ahead @ off) <= _BEFORE_M else np.inf)
    return float(worst), begin, finish
