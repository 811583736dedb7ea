"""What of the residual is neither white nor the vehicle's: a Kalman filter of two Gauss-Markov processes.

The *fast* one is the camera's slow error; the *slow* one is its mount, the slow GNSS error and the map's. Neither is a
state of the monitor's filter, and both are bounded, so that an attacker who moves slowly cannot take them along for
ever. What they leave of the residual is cut, since a camera's noise has tails.
"""

from math import exp, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.noise import FilterNoise

# Errors of mount and map change over this time, and where a vehicle comes to another road by this much.
_SLOW_S, _ROAD_M = 20.0, 0.07
# Each part stays within so many of its standard deviations. An honest vehicle is beyond 2.5 for 1.2 % of its time, in
# which it would be in alarm; beyond 3.5, for 0.05 %.
_REACH = 3.5
# A sample of the camera counts for no more than so many standard deviations (Huber).
_CUT_SIGMAS = 3.0
# Where the fast and the slow part are in the levels, and their variances and the covariance in the covariances.
FAST_PART, SLOW_PART = 0, 1
_FAST_FAST, _FAST_SLOW, _SLOW_SLOW = 0, 1, 2


@inline
def _slow_variance(noise: FilterNoise[Floats], p: int) -> float:
    return float(noise.camera_mount_m[p] ** 2 + noise.gnss_bias_m[p] ** 2)


@inline
def age_parts(level: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int, step_s: float) -> None:
    """Take (2,) levels and (3,) covariances on by a step; a covariance of -1 says that nothing is known yet."""
    fast, slow = noise.camera_bias_m[profile] ** 2, _slow_variance(noise, profile)
    if covariance[_SLOW_SLOW] < 0.0:
        level[FAST_PART], level[SLOW_PART] = 0.0, 0.0
        covariance[_FAST_FAST], covariance[_FAST_SLOW], covariance[_SLOW_SLOW] = fast, 0.0, slow
        return
    gnss_s = max(noise.gnss_bias_tau_s[profile], _SLOW_S)
    rate = noise.camera_mount_m[profile] ** 2 / _SLOW_S + noise.gnss_bias_m[profile] ** 2 / gnss_s
    a = exp(-step_s / noise.camera_bias_tau_s[profile])
    b = exp(-step_s * rate / slow) if slow > 0.0 else 1.0
    level[FAST_PART] *= a
    level[SLOW_PART] *= b
    covariance[_FAST_FAST] = a * a * covariance[_FAST_FAST] + fast * (1.0 - a * a)
    covariance[_FAST_SLOW] *= a * b
    covariance[_SLOW_SLOW] = b * b * covariance[_SLOW_SLOW] + slow * (1.0 - b * b)


@inline
def variance_of_parts(covariance: Floats) -> float:
    """Return the variance of both parts together."""
    return float(covariance[_FAST_FAST] + 2.0 * covariance[_FAST_SLOW] + covariance[_SLOW_SLOW])


@inline
def widen_slow_part(
    covariance: Floats, noise: FilterNoise[Floats], profile: int, another_lane: bool, turned: float
) -> None:
    """Widen the slow part on another lane than at the last residual, and after a turn (sine of its angle).

    Across a road of another direction, the slow GNSS error is another one.
    """
    if another_lane:
        covariance[_SLOW_SLOW] += _ROAD_M * _ROAD_M
    covariance[_SLOW_SLOW] += noise.gnss_bias_m[profile] ** 2 * turned * turned


@inline
def cut_camera(sigmas: float) -> float:
    """Return a whitened sample of the camera, cut."""
    return min(max(sigmas, -_CUT_SIGMAS), _CUT_SIGMAS)


@inline
def correct_parts(
    level: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int, innovation_m: float, total: float
) -> None:
    """Correct both parts with what they left of a residual, of which that is expected to have the variance `total`."""
    of_fast = covariance[_FAST_FAST] + covariance[_FAST_SLOW]
    of_slow = covariance[_FAST_SLOW] + covariance[_SLOW_SLOW]
    most_fast = _REACH * noise.camera_bias_m[profile]
    most_slow = _REACH * sqrt(_slow_variance(noise, profile))
    level[FAST_PART] = min(max(level[FAST_PART] + of_fast / total * innovation_m, -most_fast), most_fast)
    level[SLOW_PART] = min(max(level[SLOW_PART] + of_slow / total * innovation_m, -most_slow), most_slow)
    covariance[_FAST_FAST] -= of_fast * of_fast / total
    covariance[_FAST_SLOW] -= of_fast * of_slow / total
    covariance[_SLOW_SLOW] = max(covariance[_SLOW_SLOW] - of_slow * of_slow / total, 0.0)
