"""An EKF that refuses fixes: what any vehicle does, without a detector."""

from math import sqrt

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline
from gpsec.filters.learning import LEARNING_STATES, predict_learnt, start_learning, update_learning
from gpsec.localization.family import Filter
from gpsec.localization.learning import LEARNING_EKF

# An honest fix has a larger NIS once in a thousand times (chi-square of two degrees of freedom).
GATE_NIS = 13.816


@inline
def update_within_gate(
    mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float
) -> int:
    """Correct with a fix unless νᵀ S⁻¹ ν is over the gate; then P goes on growing, until the gate is wide enough."""
    P, white = covariance, white_m * white_m
    east, north = x_m - mean[0] - mean[3], y_m - mean[1] - mean[4]
    s_ee = P[0, 0] + 2.0 * P[0, 3] + P[3, 3] + white
    s_nn = P[1, 1] + 2.0 * P[1, 4] + P[4, 4] + white
    s_en = P[0, 1] + P[0, 4] + P[1, 3] + P[3, 4]
    innovation[0] = east / sqrt(s_ee)
    innovation[1] = (north - s_en / s_ee * east) / sqrt(max(s_nn - s_en * s_en / s_ee, 1e-12))
    if innovation[0] ** 2 + innovation[1] ** 2 > GATE_NIS:
        return 0
    return int(update_learning(mean, covariance, innovation, x_m, y_m, white_m))


GATED_EKF = Filter(
    LEARNING_STATES,
    start_learning,
    predict_learnt,
    update_within_gate,
    LEARNING_EKF.isolate,
    LEARNING_EKF.take_yaw,
    LEARNING_EKF.drift,
    LEARNING_EKF.trust,
)
