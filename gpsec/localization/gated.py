"""An EKF that refuses fixes: what any vehicle does, without a detector."""

from math import exp, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.adapting import MEAN_CUT_SQUARE, MOST_VARIANCE, cut_square, learning_gain, learnt
from gpsec.filters.learning import LEARNING_STATES, start_learning, update_learning
from gpsec.filters.noise import FilterNoise
from gpsec.localization.family import Filter
from gpsec.localization.learning import LEARNING_EKF

# λ of the sums of whitened innovations: one fix, and means over about 2.5, 6.7 and 20 of them.
FORGETS = (0.0, 0.6, 0.85, 0.95)
# An honest fix is refused about once in a thousand times.
GATE_SQUARE = 16.0
# How noisy fixes are is learnt while nothing speaks much against them.
_LEARNS_BELOW = 0.5 * GATE_SQUARE
# A fix that is e³ times likelier without the mean so far begins new sums.
_CONTRADICTS = -3.0
# Behind the states of the learning EKF: the logarithm of the learnt factor of the white variance of fixes, what a fix
# counts for in it, and for each λ: Σ λʲ w of both axes, their variances, Σ λʲ, and Σ λʲ since a fix was used.
LEARNT_NOISE, _GAIN = LEARNING_STATES, LEARNING_STATES + 1
_SUMS, _PER_SCALE = LEARNING_STATES + 2, 6
GATED_STATES = _SUMS + _PER_SCALE * len(FORGETS)


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
    mean[_GAIN] = learning_gain(noise.gnss_period_s[profile])


@inline
def _square(mean: Floats, scale: int) -> float:
    """Return the square of Σ λʲ w over its variance, of both axes together."""
    at = _SUMS + _PER_SCALE * scale
    if mean[at + 2] == 0.0:
        return 0.0
    return float(mean[at] ** 2 / mean[at + 2] + mean[at + 1] ** 2 / mean[at + 3])


@inline
def _gather(mean: Floats, first: float, second: float, shared: tuple[float, float]) -> float:
    """Take a whitened innovation into the sums; return the largest square of a scale.

    Innovations are independent as long as fixes are used. Those since a fix was used have the error of the position in
    common, which is the part `shared` of the variance of each axis.
    """
    best, most = 0, 0.0
    for scale in range(len(FORGETS)):
        square = _square(mean, scale)
        if square > most:
            best, most = scale, square
    at = _SUMS + _PER_SCALE * best
    if most > GATE_SQUARE:
        m_1, m_2 = mean[at] / mean[at + 4], mean[at + 1] / mean[at + 4]
        if m_1 * first + m_2 * second - 0.5 * (m_1 * m_1 + m_2 * m_2) < _CONTRADICTS:
            mean[_SUMS:] = 0.0
    most = 0.0
    for scale in range(len(FORGETS)):
        at = _SUMS + _PER_SCALE * scale
        decay = FORGETS[scale]
        mean[at] = decay * mean[at] + first
        mean[at + 1] = decay * mean[at + 1] + second
        for axis in range(2):
            together = 2.0 * decay * mean[at + 5] * shared[axis]
            mean[at + 2 + axis] = decay * decay * mean[at + 2 + axis] + 1.0 + together
        mean[at + 4] = decay * mean[at + 4] + 1.0
        mean[at + 5] = decay * mean[at + 5] + 1.0
        most = max(most, _square(mean, scale))
    return most


@inline
def _update_within_gate(
    mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float
) -> int:
    """Correct with a fix unless its innovation, or those of the last fixes together, are over the gate.

    Where they are, P goes on growing, until fixes are within it again. Their white variance is learnt while they are
    within half of it. Returns repairs made.
    """
    P, white = covariance, white_m * white_m * exp(mean[LEARNT_NOISE])
    east, north = x_m - mean[0] - mean[3], y_m - mean[1] - mean[4]
    s_ee = P[0, 0] + 2.0 * P[0, 3] + P[3, 3] + white
    s_nn = P[1, 1] + 2.0 * P[1, 4] + P[4, 4] + white
    s_en = P[0, 1] + P[0, 4] + P[1, 3] + P[3, 4]
    left = max(s_nn - s_en * s_en / s_ee, 1e-12)
    innovation[0] = east / sqrt(s_ee)
    innovation[1] = (north - s_en / s_ee * east) / sqrt(left)
    most = _gather(mean, innovation[0], innovation[1], (1.0 - white / s_ee, max(1.0 - white / left, 0.0)))
    if most < _LEARNS_BELOW:
        excess = cut_square(innovation[0]) + cut_square(innovation[1]) - 2.0 * MEAN_CUT_SQUARE
        mean[LEARNT_NOISE] = learnt(mean[LEARNT_NOISE], mean[_GAIN], excess, MOST_VARIANCE)
    if most > GATE_SQUARE:
        return 0
    for scale in range(len(FORGETS)):
        mean[_SUMS + _PER_SCALE * scale + 5] = 0.0
    return int(update_learning(mean, covariance, innovation, x_m, y_m, sqrt(white)))


GATED_EKF = Filter(
    GATED_STATES,
    _start,
    LEARNING_EKF.predict,
    _update_within_gate,
    LEARNING_EKF.isolate,
    LEARNING_EKF.take_yaw,
    LEARNING_EKF.drift,
    LEARNING_EKF.trust,
)
