"""The paper's UKF with what it does not estimate considered: a Schmidt-Kalman filter (Schmidt, 1966).

Position is estimated, as in Eqs 11-16: five sigma points, the camera's lane offset as observation. Yaw, the scale error
of the odometer, the bias of the gyro and the lasting errors of the camera (bias and mounting offset) are *considered*:
they have a variance, and covariances with the position, but nothing corrects them (Bierman, *Factorization Methods for
Discrete Sequential Estimation*, VIII.4). So the filter knows what does not average away, with the states that the paper
gives it. While GNSS is trusted, the EKF of normal operation considers scale and gyro bias likewise.

The state is that of `gpsec.filters.learning`, whose scale and gyro bias stay 0 here.
"""

from math import sqrt

from gpsec.core.arrays import Floats
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.filters.ekf import STATES
from gpsec.filters.learning import LEARNING_STATES, MOUNTING, SLOW, start_learning
from gpsec.hdmap.matching import offset_on, view_on
from gpsec.hdmap.search import TRACKED
from gpsec.localization.family import Filter
from gpsec.localization.lane_ukf import camera_noise
from gpsec.localization.learning import LEARNING_EKF
from gpsec.localization.paper_ukf import expect_offset
from gpsec.localization.sparse_map import map_variances
from gpsec.localization.world import LaneSight, Room, World


@inline
def update_considering(
    mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float
) -> int:
    """Correct position, yaw and slow GNSS error with a fix, one axis after the other, and return repairs made.

    S = H P Hᵀ + R and K = P Hᵀ / S as in the EKF, but the rows of K are 0 for what is considered:
    P' = (I - K H) P (I - K H)ᵀ + K R Kᵀ, in which the variances of what is considered stay.
    """
    P = covariance
    for axis in range(2):
        b = SLOW + axis
        S = P[axis, axis] + 2.0 * P[axis, b] + P[b, b] + white_m * white_m
        nu = (x_m if axis == 0 else y_m) - mean[axis] - mean[b]
        gain = (
            (P[0, axis] + P[0, b]) / S,
            (P[1, axis] + P[1, b]) / S,
            (P[2, axis] + P[2, b]) / S,
            (P[3, axis] + P[3, b]) / S,
            (P[4, axis] + P[4, b]) / S,
            (P[5, axis] + P[5, b]) / S,
            (P[6, axis] + P[6, b]) / S,
        )
        for i in range(STATES):
            mean[i] += gain[i] * nu
            for j in range(LEARNING_STATES):
                if j <= i or j >= STATES:
                    P[i, j] -= gain[i] * S * gain[j]
                    P[j, i] = P[i, j]
        innovation[axis] = nu / sqrt(S)
    mean[2] = wrap_angle(mean[2])
    repairs = 0
    for i in range(STATES):
        if P[i, i] < 0.0:
            P[i, i] = 0.0
            repairs += 1
    return repairs


@inline
def correct_considering(
    mean: Floats, covariance: Floats, hint: int, room: Room, world: World, profile: int, sight: LaneSight
) -> tuple[int, int]:
    """Correct the position with the camera's lane offset (Eqs 13-16), considering all else.

    Five sigma points of the position give the offset that is expected, its variance and its covariance with the
    position, and with these the row H of a linear observation (statistical linearisation). The camera's lasting errors
    add to what it sees: H is 1 there. What the points scatter beyond H is noise, beside the camera's white part. Of a
    sparse map the UKF takes chords; by how much the arc lies beside, and what is not known of that, is added here.

    Returns the segment of the mean (-1 where a sigma point had no match; nothing is corrected then) and repairs made.
    """
    white_m, _ = camera_noise(world.noise, profile, sight.sigma_m)
    seen = expect_offset(mean, covariance, hint, room, world, profile, sight.lane, white_m)
    segment, repairs, expected, variance, cross_x, cross_y = seen
    if segment < 0:
        return -1, repairs
    P = covariance
    det = P[0, 0] * P[1, 1] - P[0, 1] * P[0, 1]
    hx = (P[1, 1] * cross_x - P[0, 1] * cross_y) / det
    hy = (P[0, 0] * cross_y - P[0, 1] * cross_x) / det
    common = room.root[0]
    for j in range(LEARNING_STATES):
        common[j] = P[j, 0] * hx + P[j, 1] * hy + P[j, SLOW] + P[j, MOUNTING]
    lanes = world.hd_map.lanes
    extend = world.hd_map.mode == TRACKED
    chord, _ = offset_on(lanes, segment, mean[0], mean[1], mean[2], extend)
    arc, _ = view_on(lanes, segment, mean[0], mean[1], mean[2], extend)
    map_offset, _ = map_variances(world, segment, profile, sight.speed_mps)
    lasting = P[SLOW, SLOW] + 2.0 * P[SLOW, MOUNTING] + P[MOUNTING, MOUNTING]
    together = hx * (P[0, SLOW] + P[0, MOUNTING]) + hy * (P[1, SLOW] + P[1, MOUNTING])
    S = variance + map_offset + 2.0 * together + lasting
    nu = sight.offset_m - (expected + arc - chord) - mean[SLOW] - mean[MOUNTING]
    for i in range(2):
        gain = common[i] / S
        mean[i] += gain * nu
        for j in range(LEARNING_STATES):
            if j <= i or j >= 2:
                P[i, j] -= gain * common[j]
                P[j, i] = P[i, j]
    return segment, repairs


CONSIDERING_EKF = Filter(
    LEARNING_STATES,
    start_learning,
    LEARNING_EKF.predict,
    update_considering,
    LEARNING_EKF.isolate,
    LEARNING_EKF.take_yaw,
    LEARNING_EKF.drift,
    LEARNING_EKF.trust,
)
