"""Arc length, direction and curvature of lane centre lines, and resampling."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats

# Half of the base over which curvature is taken, so that the rounding of a net's coordinates is not amplified.
CURVATURE_BASE_M = 2.5


@dataclass(frozen=True)
class Polyline:
    """A centre line by its n points.

    Attributes:
        points_m: (n, 2).
        s_m: (n,) arc length.
        yaw_rad: (n,) direction of the lane, unwrapped: mean of the segments that meet; at the ends extrapolated by half
            a turn, which is exact on a circle.
        curvature_per_m: (n,) change of direction over ± `CURVATURE_BASE_M`, left positive.

    """

    points_m: Floats
    s_m: Floats
    yaw_rad: Floats
    curvature_per_m: Floats


def measure(points_m: Floats) -> Polyline:
    """Return the polyline through (n, 2) distinct points."""
    step = np.diff(points_m, axis=0)
    length = np.hypot(step[:, 0], step[:, 1])
    s = np.concatenate([[0.0], np.cumsum(length)])
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    yaw = np.empty(len(points_m))
    yaw[1:-1] = 0.5 * (heading[:-1] + heading[1:])
    if len(heading) > 1:
        yaw[0] = heading[0] - 0.5 * (heading[1] - heading[0])
        yaw[-1] = heading[-1] + 0.5 * (heading[-1] - heading[-2])
    else:
        yaw[:] = heading[0]
    low, high = np.maximum(s - CURVATURE_BASE_M, 0.0), np.minimum(s + CURVATURE_BASE_M, s[-1])
    curvature = (np.interp(high, s, yaw) - np.interp(low, s, yaw)) / (high - low)
    return Polyline(points_m, s, yaw, curvature)


def resample(line: Polyline, spacing_m: float) -> Polyline:
    """Return the line as a map of that spacing stores it: points at equal distances of at most `spacing_m`.

    The chords of a sparse map cut a curve of radius R by up to spacing²/8R.
    """
    pieces = max(1, int(np.ceil(line.s_m[-1] / spacing_m - 1e-9)))
    s = np.linspace(0.0, line.s_m[-1], pieces + 1)
    points = np.stack([np.interp(s, line.s_m, line.points_m[:, axis]) for axis in (0, 1)], axis=1)
    return measure(points)
