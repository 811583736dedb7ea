"""The UKF under attack (Eqs 11-16): GNSS isolated, state (east, north), the camera's lane offset observed.

Speed and yaw rate move the mean; 2N + 1 = 5 sigma points predict the lane offset by map matching each of them. Process
noise is additive. The weights are Merwe's, as in filterpy.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.hdmap.around import gather_around, nearest_of
from gpsec.hdmap.arrays import MapArrays, MatchIndex, Pose
from gpsec.hdmap.matching import offset_on
from gpsec.hdmap.search import MIN_COS, TRACKED, match
from gpsec.localization.ekf import process_noise
from gpsec.localization.noise import FilterNoise

# alpha = 1 and kappa = 1 put the points at sqrt(3) standard deviations, which matches the fourth moment of a Gaussian
# in two dimensions (Julier and Uhlmann, 2004: n + kappa = 3).
ALPHA, BETA, KAPPA = 1.0, 2.0, 1.0
# Segments that one search may find for all sigma points; where there are more, each point is searched for.
NEAR = 64
# A yaw that is further from the heading sensor's, in standard deviations of that, has been turned by fixes.
YAW_SIGMAS = 4.0


class SigmaWeights(NamedTuple):
    """Weights of mean and covariance, (5,) each, and n + λ."""

    mean: Floats
    covariance: Floats
    spread: float


def sigma_weights() -> SigmaWeights:
    """Return the weights of the five sigma points.

    By hand: importing filterpy takes longer than everything else that a run imports.
    """
    spread = ALPHA**2 * (2.0 + KAPPA)
    mean = np.full(5, 0.5 / spread)
    mean[0] = (spread - 2.0) / spread
    covariance = mean.copy()
    covariance[0] += 1.0 - ALPHA**2 + BETA
    return SigmaWeights(mean, covariance, spread)


@inline
def drop_polluted_yaw(mean: Floats, covariance: Floats, heading_rad: float, sigma_rad: float) -> None:
    """Take the heading sensor's yaw where the filter's contradicts it.

    Fixes that jump sideways turn the EKF's yaw (a jump of 2.4 m by some degrees), and in isolation nothing would
    correct it. The heading sensor knows nothing of fixes. Where fixes are only lost, the filter knows yaw better than
    a sensor that may be off by its bias.
    """
    if abs(wrap_angle(mean[2] - heading_rad)) > YAW_SIGMAS * sigma_rad:
        mean[2] = heading_rad
        covariance[2, 2] = sigma_rad * sigma_rad


@inline
def predict(
    mean: Floats,
    covariance: Floats,
    table: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
) -> None:
    """Propagate position by one step (Eqs 11-12), and yaw beside it.

    All sigma points are moved by the same arc, so that the unscented transform is exact: mean + arc, P + Q.
    """
    distance = speed_mps * step_s
    turn = yaw_rate_rps * step_s
    middle = mean[2] + 0.5 * turn
    mean[0], mean[1] = dead_reckon(mean[0], mean[1], mean[2], distance, turn)
    along, across, yaw = process_noise(table, profile, speed_mps, sqrt(covariance[2, 2]), step_s)
    c = cos(middle)
    s = sin(middle)
    covariance[0, 0] += along * c * c + across * s * s
    covariance[0, 1] += (along - across) * c * s
    covariance[1, 0] = covariance[0, 1]
    covariance[1, 1] += along * s * s + across * c * c
    covariance[2, 2] += yaw
    mean[2] = wrap_angle(mean[2] + turn)


@inline
def update(
    mean: Floats,
    covariance: Floats,
    weights: SigmaWeights,
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: int,
    lane: int,
    hint: int,
    offset_m: float,
    sigma_m: float,
    near: Ints,
) -> tuple[int, int]:
    """Correct with the camera's lane offset (Eqs 13-16); `near` is room to work in.

    Returns the segment of the mean (-1 where a sigma point had no match; nothing is corrected then) and repairs made.
    """
    P = covariance
    repairs = 0
    if P[0, 0] <= 0.0 or P[0, 0] * P[1, 1] - P[0, 1] * P[0, 1] <= 0.0:
        repairs = 1
        P[0, 0] = max(P[0, 0], 1e-12)
        P[1, 1] = max(P[1, 1], 1e-12)
        P[0, 1] = 0.0
        P[1, 0] = 0.0
    # Rows of the upper Cholesky factor of (n + λ) P.
    a = sqrt(weights.spread * P[0, 0])
    b = weights.spread * P[0, 1] / a
    c = sqrt(max(weights.spread * P[1, 1] - b * b, 0.0))
    ex = (0.0, a, 0.0, -a, 0.0)
    ey = (0.0, b, c, -b, -c)
    heading = mean[2]
    count = -1
    segment = hint
    if mode == TRACKED:
        reach = max(sqrt(a * a + b * b), c)
        count, segment = gather_around(lanes, index, Pose(layer, lane, mean[0], mean[1], heading), hint, reach, near)
    z0 = z1 = z2 = z3 = z4 = 0.0
    centre = -1
    for k in range(5):
        x = mean[0] + ex[k]
        y = mean[1] + ey[k]
        if count > 0:
            segment = nearest_of(lanes, near, count, x, y)
        else:
            segment = match(lanes, index, mode, Pose(layer, lane, x, y, heading), segment)
        if segment < 0:
            return -1, repairs
        z, cosine = offset_on(lanes, segment, x, y, heading, mode == TRACKED)
        if abs(cosine) < MIN_COS:
            return -1, repairs
        if k == 0:
            z0 = z
            centre = segment
        elif k == 1:
            z1 = z
        elif k == 2:
            z2 = z
        elif k == 3:
            z3 = z
        else:
            z4 = z
    zs = (z0, z1, z2, z3, z4)
    expected = 0.0
    for k in range(5):
        expected += weights.mean[k] * zs[k]
    S = sigma_m * sigma_m
    cross_x = 0.0
    cross_y = 0.0
    for k in range(5):
        dz = zs[k] - expected
        S += weights.covariance[k] * dz * dz
        cross_x += weights.covariance[k] * ex[k] * dz
        cross_y += weights.covariance[k] * ey[k] * dz
    gain_x = cross_x / S
    gain_y = cross_y / S
    mean[0] += gain_x * (offset_m - expected)
    mean[1] += gain_y * (offset_m - expected)
    P[0, 0] -= gain_x * S * gain_x
    P[0, 1] -= gain_x * S * gain_y
    P[1, 0] = P[0, 1]
    P[1, 1] -= gain_y * S * gain_y
    return centre, repairs
