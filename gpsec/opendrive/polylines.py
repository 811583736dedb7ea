"""Plain operations on the (n, 2) points of a line."""

from collections.abc import Iterable

import numpy as np

from gpsec.core.arrays import Floats, Longs


def stations(points_m: Floats) -> Floats:
    """Return (n,) lengths along a line."""
    way: Floats = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points_m, axis=0).T))])
    return way


def spread(points_m: Iterable[Floats], closest_m: float) -> Floats:
    """Leave out points that lie closer than `closest_m` to the one before or to the last; both ends stay."""
    points = np.array(list(points_m))
    return points[spread_out(points, closest_m)]


def spread_out(points_m: Floats, closest_m: float) -> Longs:
    """Return which of (n, 2) points `spread` keeps."""
    last = len(points_m) - 1
    kept = [0]
    for index in range(1, last):
        here = points_m[index]
        if min(np.hypot(*(here - points_m[kept[-1]])), np.hypot(*(here - points_m[last]))) >= closest_m:
            kept.append(index)
    return np.array([*kept, last])


def at_stations(points_m: Floats, station_m: Floats) -> Floats:
    """Return (m, 2) points at (m,) lengths along a line."""
    way = stations(points_m)
    return np.stack([np.interp(station_m, way, points_m[:, axis]) for axis in (0, 1)], axis=1)
