"""The UKF under attack (Eqs 11-16): GNSS isolated, state (east, north), the camera's lane offset observed.

Speed and yaw rate move the mean; 2N + 1 = 5 sigma points predict the lane offset by map matching each of them. Process
noise is additive. The weights are Merwe's, as in filterpy.
"""

from math import cos, sin, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.filters import ekf
from gpsec.filters.ekf import process_noise
from gpsec.filters.noise import FilterNoise
from gpsec.hdmap.around import gather_around, nearest_of
from gpsec.hdmap.arrays import Pose
from gpsec.hdmap.matching import offset_on
from gpsec.hdmap.search import MIN_COS, TRACKED, match
from gpsec.localization.family import Filter
from gpsec.localization.world import LaneSight, Room, World

# alpha = 1 and kappa = 1 put the points at sqrt(3) standard deviations, which matches the fourth moment of a Gaussian
# in two dimensions (Julier and Uhlmann, 2004: n + kappa = 3).
ALPHA, BETA, KAPPA = 1.0, 2.0, 1.0
# n + λ, and the weights of the five sigma points for mean and covariance. By hand: importing filterpy takes longer than
# everything else that a run imports.
SPREAD = ALPHA**2 * (2.0 + KAPPA)
MEAN_WEIGHTS = ((SPREAD - 2.0) / SPREAD, *[0.5 / SPREAD] * 4)
COVARIANCE_WEIGHTS = (MEAN_WEIGHTS[0] + (1.0 - ALPHA**2 + BETA), *MEAN_WEIGHTS[1:])


@inline
def _isolate(mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int) -> None:
    """Leave the EKF's state as it is: position and yaw go on, the slow GNSS error waits."""


@inline
def _take_yaw(mean: Floats, covariance: Floats, heading_rad: float, sigma_rad: float) -> None:
    """Take the yaw of the heading sensor, with its variance."""
    mean[2] = heading_rad
    covariance[2, 2] = sigma_rad * sigma_rad


@inline
def _drift(noise: FilterNoise[Floats], profile: int, way_m: float) -> float:
    """Return the variance along the way that the odometer's scale error has made in isolation."""
    return float((noise.odometer_scale[profile] * way_m) ** 2)


@inline
def predict_position(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
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
    along, across, yaw = process_noise(noise, profile, speed_mps, sqrt(covariance[2, 2]), step_s)
    c = cos(middle)
    s = sin(middle)
    covariance[0, 0] += along * c * c + across * s * s
    covariance[0, 1] += (along - across) * c * s
    covariance[1, 0] = covariance[0, 1]
    covariance[1, 1] += along * s * s + across * c * c
    covariance[2, 2] += yaw
    mean[2] = wrap_angle(mean[2] + turn)


@inline
def expect_offset(
    mean: Floats, covariance: Floats, hint: int, room: Room, world: World, profile: int, lane: int, sigma_m: float
) -> tuple[int, int, float, float, float, float]:
    """Predict the lane offset by map matching five sigma points of the position (Eqs 13-14).

    Returns the segment of the mean (-1 where a sigma point had no match), repairs made, the offset that is expected,
    the variance of what is seen with white noise of `sigma_m`, and its covariances with east and with north.
    """
    lanes, lookup, mode = world.hd_map.lanes, world.hd_map.lookup, world.hd_map.mode
    layer = world.hd_map.layer[profile]
    P = covariance
    repairs = 0
    if P[0, 0] <= 0.0 or P[0, 0] * P[1, 1] - P[0, 1] * P[0, 1] <= 0.0:
        repairs = 1
        P[0, 0] = max(P[0, 0], 1e-12)
        P[1, 1] = max(P[1, 1], 1e-12)
        P[0, 1] = 0.0
        P[1, 0] = 0.0
    # Rows of the upper Cholesky factor of (n + λ) P.
    a = sqrt(SPREAD * P[0, 0])
    b = SPREAD * P[0, 1] / a
    c = sqrt(max(SPREAD * P[1, 1] - b * b, 0.0))
    ex = (0.0, a, 0.0, -a, 0.0)
    ey = (0.0, b, c, -b, -c)
    heading = mean[2]
    count = -1
    segment = hint
    if mode == TRACKED:
        reach = max(sqrt(a * a + b * b), c)
        pose = Pose(layer, lane, mean[0], mean[1], heading)
        count, segment = gather_around(lanes, lookup, pose, hint, reach, room.near)
    z0 = z1 = z2 = z3 = z4 = 0.0
    centre = -1
    for k in range(5):
        x = mean[0] + ex[k]
        y = mean[1] + ey[k]
        if count > 0:
            segment = nearest_of(lanes, room.near, count, x, y)
        else:
            segment = match(lanes, lookup, mode, Pose(layer, lane, x, y, heading), segment)
        if segment < 0:
            return -1, repairs, 0.0, 0.0, 0.0, 0.0
        z, cosine = offset_on(lanes, segment, x, y, heading, mode == TRACKED)
        if abs(cosine) < MIN_COS:
            return -1, repairs, 0.0, 0.0, 0.0, 0.0
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
        expected += MEAN_WEIGHTS[k] * zs[k]
    variance = sigma_m * sigma_m
    cross_x = 0.0
    cross_y = 0.0
    for k in range(5):
        dz = zs[k] - expected
        variance += COVARIANCE_WEIGHTS[k] * dz * dz
        cross_x += COVARIANCE_WEIGHTS[k] * ex[k] * dz
        cross_y += COVARIANCE_WEIGHTS[k] * ey[k] * dz
    return centre, repairs, expected, variance, cross_x, cross_y


@inline
def correct_by_offset(
    mean: Floats, covariance: Floats, hint: int, room: Room, world: World, profile: int, sight: LaneSight
) -> tuple[int, int]:
    """Correct with the camera's lane offset (Eqs 13-16).

    Returns the segment of the mean (-1 where a sigma point had no match; nothing is corrected then) and repairs made.
    """
    seen = expect_offset(mean, covariance, hint, room, world, profile, sight.lane, sight.sigma_m)
    segment, repairs, expected, S, cross_x, cross_y = seen
    if segment < 0:
        return -1, repairs
    P = covariance
    gain_x = cross_x / S
    gain_y = cross_y / S
    mean[0] += gain_x * (sight.offset_m - expected)
    mean[1] += gain_y * (sight.offset_m - expected)
    P[0, 0] -= gain_x * S * gain_x
    P[0, 1] -= gain_x * S * gain_y
    P[1, 0] = P[0, 1]
    P[1, 1] -= gain_y * S * gain_y
    return segment, repairs


@inline
def _predict(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
    isolated: bool,
) -> None:
    """Propagate by one step, as the EKF of normal operation does or as the UKF."""
    if isolated:
        predict_position(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s)
    else:
        ekf.predict_pose(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s)


PAPER_FILTER = Filter(ekf.STATES, ekf.start_at_fix, _predict, ekf.update, _isolate, _take_yaw, _drift, ekf.trust)
