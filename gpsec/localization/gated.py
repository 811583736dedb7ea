"""An EKF that refuses fixes: what any vehicle does, without a detector."""

from math import sqrt

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.learning import LEARNING_STATES, predict_learnt, start_learning, update_learning
from gpsec.filters.noise import FilterNoise
from gpsec.localization.family import Filter
from gpsec.localization.learning import LEARNING_EKF

# λ of the sums of whitened innovations: one fix, and means over about 2.5, 6.7 and 20 of them.
FORGETS = (0.0, 0.6, 0.85, 0.95)
# An honest fix is refused about once in a thousand times.
GATE_SQUARE = 16.0
# A fix that is e³ times likelier without the mean so far begins new sums.
_CONTRADICTS = -3.0
# Behind the states of the learning EKF, for each λ: Σ λʲ w of both axes, Σ λʲ and Σ λ²ʲ.
_PER_SCALE = 4
GATED_STATES = LEARNING_STATES + _PER_SCALE * len(FORGETS)


@inline
def _start(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
) -> None:
    """Start at the first fix."""
    start_learning(mean, covariance, noise, profile, x_m, y_m, heading_rad)
    mean[LEARNING_STATES:] = 0.0


@inline
def _square(mean: Floats, scale: int) -> float:
    """Return |Σ λʲ w|² / Σ λ²ʲ."""
    at = LEARNING_STATES + _PER_SCALE * scale
    return float((mean[at] ** 2 + mean[at + 1] ** 2) / mean[at + 3]) if mean[at + 3] > 0.0 else 0.0


@inline
def _gather(mean: Floats, first: float, second: float) -> float:
    """Take a whitened innovation into the sums; return the largest square of a scale."""
    best, most = 0, 0.0
    for scale in range(len(FORGETS)):
        square = _square(mean, scale)
        if square > most:
            best, most = scale, square
    at = LEARNING_STATES + _PER_SCALE * best
    if most > GATE_SQUARE:
        m_1, m_2 = mean[at] / mean[at + 2], mean[at + 1] / mean[at + 2]
        if m_1 * first + m_2 * second - 0.5 * (m_1 * m_1 + m_2 * m_2) < _CONTRADICTS:
            mean[LEARNING_STATES:] = 0.0
    most = 0.0
    for scale in range(len(FORGETS)):
        at = LEARNING_STATES + _PER_SCALE * scale
        decay = FORGETS[scale]
        mean[at] = decay * mean[at] + first
        mean[at + 1] = decay * mean[at + 1] + second
        mean[at + 2] = decay * mean[at + 2] + 1.0
        mean[at + 3] = decay * decay * mean[at + 3] + 1.0
        most = max(most, _square(mean, scale))
    return most


@inline
def _update_within_gate(
    mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float
) -> int:
    """Correct with a fix unless its innovation, or those of the last fixes together, are over the gate.

    Where they are, P goes on growing, until fixes are within it again. Returns repairs made.
    """
    P, white = covariance, white_m * white_m
    east, north = x_m - mean[0] - mean[3], y_m - mean[1] - mean[4]
    s_ee = P[0, 0] + 2.0 * P[0, 3] + P[3, 3] + white
    s_nn = P[1, 1] + 2.0 * P[1, 4] + P[4, 4] + white
    s_en = P[0, 1] + P[0, 4] + P[1, 3] + P[3, 4]
    innovation[0] = east / sqrt(s_ee)
    innovation[1] = (north - s_en / s_ee * east) / sqrt(max(s_nn - s_en * s_en / s_ee, 1e-12))
    if _gather(mean, innovation[0], innovation[1]) > GATE_SQUARE:
        return 0
    return int(update_learning(mean, covariance, innovation, x_m, y_m, white_m))


GATED_EKF = Filter(
    GATED_STATES,
    _start,
    predict_learnt,
    _update_within_gate,
    LEARNING_EKF.isolate,
    LEARNING_EKF.take_yaw,
    LEARNING_EKF.drift,
    LEARNING_EKF.trust,
)
