"""The filter of responses that learn: what it does when GNSS is given up, and when it is taken back.

Its motion is that of `gpsec.filters.learning`.
"""

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.learning import (
    LEARNING_STATES,
    SLOW,
    SLOW_NORTH,
    predict_learnt,
    start_learning,
    update_learning,
)
from gpsec.filters.noise import FilterNoise
from gpsec.localization.family import Filter


@inline
def _isolate(mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int) -> None:
    """Put the camera's slow error, of which nothing is known yet, in the place of that of GNSS."""
    for axis in (SLOW, SLOW_NORTH):
        mean[axis] = 0.0
        for i in range(LEARNING_STATES):
            covariance[axis, i] = 0.0
            covariance[i, axis] = 0.0
    covariance[SLOW, SLOW] = noise.camera_bias_m[profile] ** 2 + noise.camera_mount_m[profile] ** 2


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
    LEARNING_STATES, start_learning, predict_learnt, update_learning, _isolate, _take_yaw, _drift, _trust
)
