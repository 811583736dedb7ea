"""Places where fixes are off by multipath: drawn in netedit, or scattered over the road."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, pi, radians, sin
from typing import Any, NamedTuple, Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.core.noise import MULTIPATH_DIRECTION, MULTIPATH_PLACE, plain_uniform, vehicle_key
from gpsec.hdmap.arrays import MapArrays
from gpsec.types.constants import PREFIX
from gpsec.types.drawn_zones import (
    MULTIPATH_ZONE,
    DrawnZone,
    check_finite,
    check_polygon,
    number,
    prepared_polygon,
    stated,
)

ERROR, DIRECTION = "error_m", "direction_deg"
MULTIPATH_KEYS = (PREFIX + ERROR, PREFIX + DIRECTION)
"""The parameters of a zone, by their whole names."""
MAX_ERROR_M = 100.0
# Roads are weighed by points this far apart.
_GRAIN_M = 2.0
# Columns of squares that are numbered without a gap; a net is far smaller.
_COLUMNS = 1 << 24


class Area(NamedTuple):
    """An area of multipath.

    Attributes:
        name: id in the drawing, or number of a place that was drawn at random.
        shape_m: (n, 2) corners.
        size_m: of the error.
    """

    name: str
    shape_m: Floats
    size_m: float


class Places(Protocol):
    """Where multipath is, and what it does there."""

    def error_m(self, position_m: Floats) -> Floats:
        """Return the (n, 2) errors, east and north, of fixes at (n, 2) true positions; 0 outside."""
        ...

    def areas(self) -> list[Area]:
        """Return where it is, for maps."""
        ...


@dataclass(frozen=True, eq=False)
class DrawnMultipath:
    """A polygon in which every fix is off by the same vector.

    Attributes:
        zone_id: id in the drawing.
        polygon: of shapely, prepared.
        vector_m: (2,) east and north.
    """

    zone_id: str
    polygon: Any = field(repr=False)
    vector_m: Floats

    def error_m(self, position_m: Floats) -> Floats:
        """Return the (n, 2) errors of fixes at (n, 2) true positions."""
        inside = shapely.contains_xy(self.polygon, position_m[:, 0], position_m[:, 1])
        error: Floats = inside[:, None] * self.vector_m
        return error

    def areas(self) -> list[Area]:
        """Return the polygon."""
        corners = shapely.get_coordinates(self.polygon)[:-1]
        return [Area(self.zone_id, corners, float(np.hypot(*self.vector_m)))]


@dataclass(frozen=True, eq=False)
class ScatteredMultipath:
    """Squares of the net's frame, in each of which every fix is off by a vector of its own.

    Attributes:
        side_m: of a square.
        first: (2,) number of the first square, east and north.
        vectors_m: (columns, rows, 2) east and north, with a border of zeros.
    """

    side_m: float
    first: tuple[int, int]
    vectors_m: Floats

    def error_m(self, position_m: Floats) -> Floats:
        """Return the (n, 2) errors of fixes at (n, 2) true positions."""
        last = np.array(self.vectors_m.shape[:2]) - 1
        square = np.clip(np.floor(position_m / self.side_m).astype(np.int64) - self.first, 0, last)
        error: Floats = self.vectors_m[square[:, 0], square[:, 1]]
        return error

    def areas(self) -> list[Area]:
        """Return the squares."""
        size_m = np.hypot(self.vectors_m[..., 0], self.vectors_m[..., 1])
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        return [
            Area(f"multipath {number}", (self.first + square + corners) * self.side_m, float(size_m[tuple(square)]))
            for number, square in enumerate(np.argwhere(size_m > 0.0), start=1)
        ]


def drawn_multipath(zones: Iterable[DrawnZone], seed: int) -> list[DrawnMultipath]:
    """Return the multipath zones among `zones`.

    The error of a zone that states no direction has one that is drawn from `seed` and its id.

    Raises:
        GpsecError: a zone is no polygon, has no size of the error, or a parameter that is not allowed.
    """
    return [_drawn(zone, seed) for zone in zones if zone.zone_type == MULTIPATH_ZONE]


def _drawn(zone: DrawnZone, seed: int) -> DrawnMultipath:
    where = zone.where
    if zone.kind != "polygon":
        raise GpsecError(f"{where}: expected a polygon for multipath, found a point")
    check_finite(zone.shape_m, where)
    check_polygon(zone.shape_m, where)
    given = stated(zone.parameters)
    size_m = _bounded(given, ERROR, where, MAX_ERROR_M)
    if DIRECTION in given:
        angle = radians(_bounded(given, DIRECTION, where, 360.0, -360.0))
    else:
        angle = 2.0 * pi * plain_uniform(vehicle_key(seed, zone.zone_id), MULTIPATH_DIRECTION, 0)
    return DrawnMultipath(zone.zone_id, prepared_polygon(zone.shape_m), _vector(size_m, angle))


def _bounded(given: Mapping[str, str], key: str, where: str, most: float, least: float = 0.0) -> float:
    if key not in given:
        raise GpsecError(f"{where}: {PREFIX}{key}: expected a number from {least:g} to {most:g}, found none")
    value = number(given[key], key, where)
    if not least <= value <= most:
        raise GpsecError(f"{where}: {PREFIX}{key}: expected a number from {least:g} to {most:g}, found {value:g}")
    return value


def scattered_multipath(
    lanes: MapArrays, share: float, size_m: float, side_m: float, seed: int
) -> ScatteredMultipath | None:
    """Return squares of `side_m` that hold `share` of the length of the true lanes, None where they hold nothing.

    The squares are taken in an order that is drawn from `seed`, until they hold the share as nearly as whole squares
    can. In each of them fixes are off by `size_m`, in a direction that is drawn for it.
    """
    squares, length_m = _roads(lanes, side_m)
    key = vehicle_key(seed, "multipath")
    drawn = [plain_uniform(key, MULTIPATH_PLACE, _number(square)) for square in squares.tolist()]
    order = np.argsort(drawn, kind="stable")
    held = np.concatenate([[0.0], np.cumsum(length_m[order])]) / length_m.sum()
    chosen = squares[order[: int(np.argmin(np.abs(held - share)))]]
    if not len(chosen):
        return None
    first = chosen.min(axis=0) - 1
    vectors_m = np.zeros((*(chosen.max(axis=0) - first + 2), 2))
    for square in chosen.tolist():
        angle = 2.0 * pi * plain_uniform(key, MULTIPATH_DIRECTION, _number(square))
        vectors_m[square[0] - first[0], square[1] - first[1]] = _vector(size_m, angle)
    return ScatteredMultipath(side_m, (int(first[0]), int(first[1])), vectors_m)


def _roads(lanes: MapArrays, side_m: float) -> tuple[NDArray[np.int64], Floats]:
    """Return the (n, 2) squares that the true lanes lead through, and the (n,) length of lanes in each."""
    true = slice(0, int(lanes.first[0, -1] + lanes.segments[0, -1]))
    length_m = lanes.length_m[true]
    pieces = np.ceil(length_m / _GRAIN_M).astype(np.int64)
    owner = np.repeat(np.arange(len(pieces)), pieces)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    along_m = (place + 0.5) * (length_m / pieces)[owner]
    start = np.stack([lanes.x0_m[true], lanes.y0_m[true]], axis=1)
    unit = np.stack([lanes.dx[true], lanes.dy[true]], axis=1)
    squares = np.floor((start[owner] + along_m[:, None] * unit[owner]) / side_m).astype(np.int64)
    found, of = np.unique(squares, axis=0, return_inverse=True)
    return found, np.bincount(of.ravel(), weights=(length_m / pieces)[owner]).astype(np.float64)


def _number(square: Sequence[int]) -> int:
    return square[1] * _COLUMNS + square[0]


def _vector(size_m: float, angle_rad: float) -> Floats:
    return np.array([size_m * cos(angle_rad), size_m * sin(angle_rad)])
