"""Multipath that depends on the place: who drives the same street is off by the same vector.

The error of an axis is σ·exp(s·m(place))·n(place) with two smooth fields of standard normal values. A field has a draw
at each corner of a square grid and weighs the four around a place; the weights' root of the sum of squares is divided
out, so that the variance is 1 everywhere. Places with much multipath are wider than the field of the error itself.
"""

from math import exp, floor, sqrt

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.noise import CANYON_EAST, CANYON_NORTH, CANYON_SIZE, normal
from gpsec.types.vehicles import Measurements, Vehicles

# Columns of `ProfileTable.multipath`: σ in a middling place, spread of its logarithm, side of the grid's squares.
CANYON_SCALE, CANYON_SPREAD, CANYON_SIDE = range(3)
NO_MULTIPATH = (0.0, 0.0, 1.0)
WIDER = 4.0
"""Side of the squares of how much multipath there is over that of the error itself."""
_MIDDLE = 1 << 20
_COLUMNS = 1 << 21


def rms_m(scale_m: float, spread: float) -> float:
    """Return the root mean square of an axis over all places: the mean of exp(2·s·m) is exp(2·s²)."""
    return scale_m * exp(spread * spread)


@inline
def smooth_normal(key: np.uint64, channel: int, east: float, north: float) -> float:
    """Return the value of a field at a place, in sides of its squares."""
    column, row = floor(east), floor(north)
    u, v = east - column, north - row
    total, squares = 0.0, 0.0
    for right in range(2):
        for up in range(2):
            weight = (u if right else 1.0 - u) * (v if up else 1.0 - v)
            corner = (int(row) + up + _MIDDLE) * _COLUMNS + int(column) + right + _MIDDLE
            total += weight * normal(key, channel, corner)
            squares += weight * weight
    return total / sqrt(squares)


@kernel
def add_multipath(rows: Ints, key: np.uint64, multipath: Floats, vehicles: Vehicles, out: Measurements) -> None:
    """Add to the fixes of vehicle `rows` what the places do where they are; `multipath` has a row a profile."""
    for row in rows:
        p = vehicles.profile[row]
        if multipath[p, CANYON_SCALE] <= 0.0:
            continue
        east, north = (
            vehicles.rear_m[row, 0] / multipath[p, CANYON_SIDE],
            vehicles.rear_m[row, 1] / multipath[p, CANYON_SIDE],
        )
        much = smooth_normal(key, CANYON_SIZE, east / WIDER, north / WIDER)
        size = multipath[p, CANYON_SCALE] * exp(multipath[p, CANYON_SPREAD] * much)
        out.fix_m[row, 0] += size * smooth_normal(key, CANYON_EAST, east, north)
        out.fix_m[row, 1] += size * smooth_normal(key, CANYON_NORTH, east, north)
