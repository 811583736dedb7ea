"""The roads of an OpenDRIVE file: geometry and speeds of their lanes."""

from dataclasses import dataclass
from functools import cached_property
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.opendrive.curves import ReferenceLineCurve


@dataclass(frozen=True)
class Cubics:
    """A value along a road that is a cubic polynomial from each of n stations to the next.

    Attributes:
        start_m: (n,) stations, increasing.
        coefficients: (n, 4) of powers of the distance from the station.
    """

    start_m: Floats
    coefficients: Floats

    @classmethod
    def of(cls, records: list[tuple[float, ...]]) -> "Cubics":
        """Return the value that (station, a, b, c, d) describe, in any order."""
        table = np.array(sorted(records, key=lambda record: record[0]), np.float64).reshape(-1, 5)
        return cls(table[:, 0], table[:, 1:])

    def at(self, station_m: Floats) -> Floats:
        """Return the value at (m,) stations; it is 0 before the first polynomial."""
        if not len(self.start_m):
            return np.zeros_like(station_m)
        piece = np.searchsorted(self.start_m, station_m, side="right") - 1
        a, b, c, d = self.coefficients[np.maximum(piece, 0)].T
        t = station_m - self.start_m[np.maximum(piece, 0)]
        return np.where(piece >= 0, a + t * (b + t * (c + t * d)), 0.0)

    def about(self, station_m: float) -> Floats:
        """Return (4,) coefficients of powers of the distance from a station that hold at it; 0 before the first."""
        piece = int(np.searchsorted(self.start_m, station_m, side="right")) - 1
        if piece < 0:
            return np.zeros(4)
        a, b, c, d = self.coefficients[piece]
        t = station_m - self.start_m[piece]
        return np.array([a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * 3.0 * d), c + 3.0 * t * d, d])


@dataclass(frozen=True)
class Geometry:
    """One curve of a reference line, with the station and the pose at which it begins."""

    station_m: float
    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    curve: ReferenceLineCurve


@dataclass(frozen=True)
class RoadLane:
    """One lane of a lane section.

    Attributes:
        lane_id: left of the reference line positive, right negative.
        kind: ``driving``, ``shoulder``, …
        width: from the beginning of the section on.
        level: it is horizontal where the road is tilted.
        reversed: it is driven against the direction of its side.
        speeds: (distance from the beginning of the section, limit in m/s) as written, also where not positive.
        before, behind: id of the lane that it continues in the section before and behind (by station), None where it
            does not.
        element: what it was read from.
    """

    lane_id: int
    kind: str
    width: Cubics
    level: bool
    reversed: bool
    speeds: tuple[tuple[float, float | None], ...]
    before: int | None
    behind: int | None
    element: Element


@dataclass(frozen=True)
class LaneSection:
    """The lanes between two stations of a road."""

    begin_m: float
    end_m: float
    lanes: tuple[RoadLane, ...]


@dataclass(frozen=True)
class Road:
    """One road.

    Attributes:
        road_id, junction: as written; `junction` is "-1" outside of junctions.
        length_m: of the reference line.
        left_hand: traffic keeps left.
        geometries: the reference line, by station.
        lane_offset: of the centre lane from the reference line.
        superelevation: roll (rad); widths lie in the tilted plane, but for lanes that are level.
        sections: by station.
        speeds: (station, limit in m/s, None where there is none) of the road's types.
    """

    road_id: str
    junction: str
    length_m: float
    left_hand: bool
    geometries: tuple[Geometry, ...]
    lane_offset: Cubics
    superelevation: Cubics
    sections: tuple[LaneSection, ...]
    speeds: tuple[tuple[float, float | None], ...]

    @cached_property
    def _starts_m(self) -> Floats:
        return np.array([geometry.station_m for geometry in self.geometries])

    def reference(self, station_m: Floats) -> tuple[Floats, Floats]:
        """Return (n, 2) points and (n,) headings of the reference line at (n,) stations."""
        points, heading = np.empty((len(station_m), 2)), np.empty(len(station_m))
        piece = np.clip(np.searchsorted(self._starts_m, station_m, side="right") - 1, 0, None)
        for number in np.unique(piece):
            geometry = self.geometries[number]
            mask = piece == number
            course = geometry.curve.course(station_m[mask] - geometry.station_m, geometry.length_m)
            cos, sin = np.cos(geometry.heading_rad), np.sin(geometry.heading_rad)
            points[mask, 0] = geometry.x_m + cos * course.u_m - sin * course.v_m
            points[mask, 1] = geometry.y_m + sin * course.u_m + cos * course.v_m
            heading[mask] = geometry.heading_rad + course.turn_rad
        return points, heading
