"""Plain operations on the (n, 2) points of a line."""

from collections.abc import Iterable

import numpy as np

from gpsec.arrays import Floats


def stations(points_m: Floats) -> Floats:
    """Return (n,) lengths along a line."""
    way: Floats = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points_m, axis=0).T))])
    return way


def spread(points_m: Iterable[Floats], closest_m: float) -> Floats:
    """Leave out points that lie closer than `closest_m` to the one before or to the last; both ends stay."""
    listed = list(points_m)
    kept = [listed[0]]
    for point in listed[1:-1]:
        if min(np.hypot(*(point - kept[-1])), np.hypot(*(point - listed[-1]))) >= closest_m:
            kept.append(point)
    return np.array([*kept, listed[-1]])


def at_stations(points_m: Floats, station_m: Floats) -> Floats:
    """Return (m, 2) points at (m,) lengths along a line."""
    way = stations(points_m)
    return np.stack([np.interp(station_m, way, points_m[:, axis]) for axis in (0, 1)], axis=1)
