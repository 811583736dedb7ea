"""The filter of responses that learn: what it does when GNSS is given up, and when it is taken back.

Its motion is that of `gpsec.filters.learning`, and allows for a body that does not turn evenly within a step.
"""

from math import pi

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.ekf import add_along
from gpsec.filters.learning import (
    GYRO_ERROR,
    LEARNING_STATES,
    MOUNTING,
    SCALE,
    SLOW,
    SLOW_NORTH,
    lead,
    predict_learnt,
    start_learning,
    update_learning,
)
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.localization.family import Filter

# From the front to the rear axle of a car of 4.6 m (`gpsec.traffic.body`); the error of longer bodies is smaller.
BODY_AXLE_M = 3.6


@inline
def predict_body(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
    isolated: bool,
) -> None:
    """Propagate by one step, and add the variance across the way by which a body is off that does not turn evenly.

    Its front goes straight on in a step, and the rear axle, L behind, turns more in the first half of it: its way
    points along yaw + θ (1/2 + d/12L) and not along the mean arc's yaw + θ/2. That lasts for a turn, and is taken for
    noise of `LASTING_ERROR_S` correlation.
    """
    rate = yaw_rate_rps - mean[GYRO_ERROR]
    turn, distance = rate * step_s, speed_mps * step_s / (1.0 + mean[SCALE])
    course = mean[2] + lead(noise, profile, rate) + 0.5 * turn
    beside = turn * distance * distance / (12.0 * BODY_AXLE_M)
    predict_learnt(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s, isolated)
    add_along(covariance, beside * beside * LASTING_ERROR_S / step_s, course + 0.5 * pi)


@inline
def _isolate(mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int) -> None:
    """Put the camera's slow error and mounting offset, of which nothing is known yet, in the place of those of GNSS."""
    for axis in (SLOW, SLOW_NORTH):
        mean[axis] = 0.0
        for i in range(LEARNING_STATES):
            covariance[axis, i] = 0.0
            covariance[i, axis] = 0.0
    covariance[SLOW, SLOW] = noise.camera_bias_m[profile] ** 2
    covariance[MOUNTING, MOUNTING] = noise.camera_mount_m[profile] ** 2


@inline
def _take_yaw(mean: Floats, covariance: Floats, heading_rad: float, sigma_rad: float) -> None:
    """Take the yaw of the heading sensor, which knows nothing of the other states."""
    mean[2] = heading_rad
    for i in range(LEARNING_STATES):
        covariance[2, i] = 0.0
        covariance[i, 2] = 0.0
    covariance[2, 2] = sigma_rad * sigma_rad


@inline
def _drift(noise: FilterNoise[Floats], profile: int, way_m: float) -> float:
    """Return 0: what the odometer's scale error makes of the way is in the covariance."""
    return 0.0


@inline
def _trust(mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int) -> None:
    """Put the slow GNSS error back, as unknown as at the start; scale and bias stay learnt."""
    _isolate(mean, covariance, noise, profile)
    covariance[SLOW, SLOW] = noise.gnss_bias_m[profile] ** 2
    covariance[SLOW_NORTH, SLOW_NORTH] = noise.gnss_bias_m[profile] ** 2


LEARNING_EKF = Filter(
    LEARNING_STATES, start_learning, predict_body, update_learning, _isolate, _take_yaw, _drift, _trust
)
