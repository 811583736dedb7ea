"""Zero-speed updates: a vehicle that stands does not turn, so that its gyro measures its own error.

Without, the yaw of a vehicle that has stood for minutes is so unsure that an attacker can turn its filter unnoticed.
"""

from math import exp

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon
from gpsec.core.kernels import inline
from gpsec.filters.ekf import add_along
from gpsec.filters.learning import GYRO_ERROR, LEARNING_STATES, SLOW, SLOW_NORTH, predict_learnt
from gpsec.filters.noise import FilterNoise

# A vehicle stands below this speed, or below so many standard deviations of its odometer's noise …
_STANDING_MPS, _STANDING_SIGMAS = 0.03, 2.0
# … unless its gyro says that it turns: a vehicle that creeps round a bend must not teach a bias.
_TURNING_SIGMAS = 4.0
# Of the gyro's noise (rad²/s²), where a profile has none.
_LEAST_VARIANCE = 1e-12


@inline
def _gyro_variance(noise: FilterNoise[Floats], profile: int) -> float:
    return max(float(noise.gyro_white_rps[profile] ** 2), _LEAST_VARIANCE)


@inline
def _is_standing(
    mean: Floats, P: Floats, noise: FilterNoise[Floats], profile: int, speed_mps: float, yaw_rate_rps: float
) -> bool:
    """Return whether nothing but noise is in an odometer's speed, and nothing but noise and bias in a yaw rate."""
    slow = max(_STANDING_MPS, _STANDING_SIGMAS * noise.odometer_white_mps[profile])
    spread = P[GYRO_ERROR, GYRO_ERROR] + _gyro_variance(noise, profile)
    turned = yaw_rate_rps - mean[GYRO_ERROR]
    return bool(abs(speed_mps) < slow and turned * turned < _TURNING_SIGMAS**2 * spread)


@inline
def _stand(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
) -> None:
    """Take a step in which the vehicle does not turn, and measure the gyro's bias: z = g, R = σ² of its noise.

    What the odometer says is a way all the same, since a vehicle may creep.
    """
    P = covariance
    mean[0], mean[1] = dead_reckon(mean[0], mean[1], mean[2], speed_mps * step_s, 0.0)
    add_along(P, (noise.odometer_white_mps[profile] * step_s) ** 2, mean[2])
    decay = exp(-step_s / noise.gnss_bias_tau_s[profile])
    keeps = exp(-step_s / noise.gyro_bias_tau_s[profile])
    for state, factor in ((SLOW, decay), (SLOW_NORTH, decay), (GYRO_ERROR, keeps)):
        mean[state] *= factor
        for j in range(LEARNING_STATES):
            P[state, j] *= factor
        for i in range(LEARNING_STATES):
            P[i, state] *= factor
    fresh = noise.gnss_bias_m[profile] ** 2 * (1.0 - decay * decay)
    P[SLOW, SLOW] += fresh
    P[SLOW_NORTH, SLOW_NORTH] += fresh
    P[GYRO_ERROR, GYRO_ERROR] += noise.gyro_bias_rps[profile] ** 2 * (1.0 - keeps * keeps)
    S = P[GYRO_ERROR, GYRO_ERROR] + _gyro_variance(noise, profile)
    nu = yaw_rate_rps - mean[GYRO_ERROR]
    gain = (
        P[0, GYRO_ERROR] / S,
        P[1, GYRO_ERROR] / S,
        P[2, GYRO_ERROR] / S,
        P[3, GYRO_ERROR] / S,
        P[4, GYRO_ERROR] / S,
        P[5, GYRO_ERROR] / S,
        P[6, GYRO_ERROR] / S,
    )
    for i in range(LEARNING_STATES):
        mean[i] += gain[i] * nu
        for j in range(i + 1):
            P[i, j] -= gain[i] * S * gain[j]
            P[j, i] = P[i, j]


@inline
def move_or_stand(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
) -> None:
    """Take a step with a filter that learns and trusts GNSS."""
    if _is_standing(mean, covariance, noise, profile, speed_mps, yaw_rate_rps):
        _stand(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s)
    else:
        predict_learnt(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s, False)
