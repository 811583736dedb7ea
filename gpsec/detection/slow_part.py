"""The slow part of the residual: a scalar Kalman filter of the camera's bias, its mount and the slow GNSS error.

It is a first-order Gauss-Markov process whose variance is the sum of theirs. It is no state of the monitor's filter,
and bounded, so that an attacker who moves slowly cannot take it along for ever.
"""

from math import exp, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.noise import FilterNoise

# Errors of camera and map change over this time, and where a vehicle comes to another road by this much.
_SLOW_S, _ROAD_M = 20.0, 0.07
# The slow part stays within so many of its standard deviations. An honest vehicle is beyond 2.5 for 1.2 % of its time,
# in which it would be in alarm; beyond 3.5, for 0.05 %.
_REACH = 3.5


@inline
def _stationary(noise: FilterNoise[Floats], p: int) -> float:
    return float(noise.camera_bias_m[p] ** 2 + noise.camera_mount_m[p] ** 2 + noise.gnss_bias_m[p] ** 2)


@inline
def aged(level: float, variance: float, noise: FilterNoise[Floats], profile: int, step_s: float) -> tuple[float, float]:
    """Return level and variance of the slow part after a step; a variance of -1 says that nothing is known yet."""
    stationary = _stationary(noise, profile)
    if variance < 0.0:
        return 0.0, stationary
    camera = noise.camera_bias_m[profile] ** 2 + noise.camera_mount_m[profile] ** 2
    gnss_s = max(noise.gnss_bias_tau_s[profile], _SLOW_S)
    rate = camera / _SLOW_S + noise.gnss_bias_m[profile] ** 2 / gnss_s
    decay = exp(-step_s * rate / stationary) if stationary > 0.0 else 1.0
    return decay * level, decay * decay * variance + stationary * (1.0 - decay * decay)


@inline
def on_another_road(
    variance: float, noise: FilterNoise[Floats], profile: int, another_lane: bool, turned: float
) -> float:
    """Return the variance on another lane than at the last residual, after a turn (sine of its angle).

    Across a road of another direction, the slow GNSS error is another one.
    """
    if another_lane:
        variance += _ROAD_M * _ROAD_M
    return float(variance + noise.gnss_bias_m[profile] ** 2 * turned * turned)


@inline
def followed(
    level: float, variance: float, noise: FilterNoise[Floats], profile: int, residual_m: float, white: float
) -> tuple[float, float]:
    """Return level and variance, corrected with a residual whose white part has the variance `white`."""
    gain = variance / (variance + white)
    bound = _REACH * sqrt(_stationary(noise, profile))
    return min(max(level + gain * (residual_m - level), -bound), bound), variance * (1.0 - gain)
