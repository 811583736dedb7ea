"""The EKF of normal operation: wheel speed and yaw rate propagate, GNSS corrects.

State (east, north, yaw, slow GNSS error east, slow GNSS error north). GNSS error is coloured; the slow part is a
first-order Gauss-Markov state of the filter (Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to
Tracking and Navigation*, 8.2), so that the covariance does not shrink as if every fix were independent.
"""

from math import cos, exp, sin, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.localization.noise import LASTING_ERROR_S, FilterNoise


@inline
def start(
    mean: Floats,
    covariance: Floats,
    table: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
) -> None:
    """Start a filter at its first fix: position = fix - slow error, so the two are correlated from the beginning."""
    bias = table.gnss_bias_m[profile] ** 2
    position = table.gnss_white_m[profile] ** 2 + bias
    covariance[:, :] = 0.0
    for axis in range(2):
        covariance[axis, axis] = position
        covariance[3 + axis, 3 + axis] = bias
        covariance[axis, 3 + axis] = -bias
        covariance[3 + axis, axis] = -bias
    covariance[2, 2] = table.heading_rad[profile] ** 2
    mean[0] = x_m
    mean[1] = y_m
    mean[2] = wrap_angle(heading_rad)
    mean[3] = 0.0
    mean[4] = 0.0


@inline
def process_noise(
    table: FilterNoise[Floats], profile: int, speed_mps: float, yaw_sigma_rad: float, step_s: float
) -> tuple[float, float, float]:
    """Return the variances that a step adds along the body, across it, and to yaw.

    Along: white odometer noise, and the scale error as noise of `LASTING_ERROR_S` correlation. Across: a yaw error of
    `yaw_sigma_rad` in the same way (0 where yaw is a state of the filter).
    """
    lasting = step_s * LASTING_ERROR_S
    scale = table.odometer_scale[profile] * speed_mps
    along = (table.odometer_white_mps[profile] * step_s) ** 2 + scale * scale * lasting
    across = (yaw_sigma_rad * speed_mps) ** 2 * lasting
    yaw = (table.gyro_white_rps[profile] * step_s) ** 2 + table.gyro_bias_rps[profile] ** 2 * lasting
    return along, across, yaw


@inline
def predict(
    mean: Floats,
    covariance: Floats,
    table: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
) -> None:
    """Propagate by one step: x' = f(x, u), P' = F P Fᵀ + Q, with the circular arc that speed and yaw rate describe."""
    P = covariance
    distance = speed_mps * step_s
    turn = yaw_rate_rps * step_s
    x, y = dead_reckon(mean[0], mean[1], mean[2], distance, turn)
    # F is the identity but for d(east)/d(yaw) = -(y' - y), d(north)/d(yaw) = x' - x, and the decay of the slow error.
    f02 = -(y - mean[1])
    f12 = x - mean[0]
    middle = mean[2] + 0.5 * turn
    tau = table.gnss_bias_tau_s[profile]
    decay = exp(-step_s / tau)
    for j in range(5):
        P[0, j] += f02 * P[2, j]
        P[1, j] += f12 * P[2, j]
        P[3, j] *= decay
        P[4, j] *= decay
    for i in range(5):
        P[i, 0] += f02 * P[i, 2]
        P[i, 1] += f12 * P[i, 2]
        P[i, 3] *= decay
        P[i, 4] *= decay
    along, _, yaw = process_noise(table, profile, speed_mps, 0.0, step_s)
    c = cos(middle)
    s = sin(middle)
    P[0, 0] += along * c * c
    P[0, 1] += along * c * s
    P[1, 0] += along * c * s
    P[1, 1] += along * s * s
    P[2, 2] += yaw
    fresh = table.gnss_bias_m[profile] ** 2 * (1.0 - decay * decay)
    P[3, 3] += fresh
    P[4, 4] += fresh
    mean[0] = x
    mean[1] = y
    mean[2] = wrap_angle(mean[2] + turn)
    mean[3] *= decay
    mean[4] *= decay


@inline
def update(mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float) -> int:
    """Correct with a fix, one axis after the other (their white errors are independent), and return repairs made.

    For each axis H = e_axis + e_(3+axis); S = H P Hᵀ + R, K = P Hᵀ / S, P' = P - K S Kᵀ.
    """
    P = covariance
    repairs = 0
    for axis in range(2):
        S = P[axis, axis] + 2.0 * P[axis, 3 + axis] + P[3 + axis, 3 + axis] + white_m * white_m
        nu = (x_m if axis == 0 else y_m) - mean[axis] - mean[3 + axis]
        k0 = (P[0, axis] + P[0, 3 + axis]) / S
        k1 = (P[1, axis] + P[1, 3 + axis]) / S
        k2 = (P[2, axis] + P[2, 3 + axis]) / S
        k3 = (P[3, axis] + P[3, 3 + axis]) / S
        k4 = (P[4, axis] + P[4, 3 + axis]) / S
        gain = (k0, k1, k2, k3, k4)
        for i in range(5):
            mean[i] += gain[i] * nu
            for j in range(i + 1):
                P[i, j] -= gain[i] * S * gain[j]
                P[j, i] = P[i, j]
        innovation[axis] = nu / sqrt(S)
    mean[2] = wrap_angle(mean[2])
    for i in range(5):
        if P[i, i] < 0.0:
            P[i, i] = 0.0
            repairs += 1
    return repairs
