"""The EKF of normal operation: wheel speed and yaw rate propagate, GNSS corrects.

State (east, north, yaw, slow GNSS error east, slow GNSS error north). GNSS error is coloured; the slow part is a
first-order Gauss-Markov state of the filter (Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to
Tracking and Navigation*, 8.2), so that the covariance does not shrink as if every fix were independent.
"""

from collections.abc import Callable
from math import cos, exp, sin, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise

STATES = 5


@inline
def start_at_fix(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
) -> None:
    """Start a filter at its first fix: position = fix - slow error, so the two are correlated from the beginning."""
    bias = noise.gnss_bias_m[profile] ** 2
    position = noise.gnss_white_m[profile] ** 2 + bias
    covariance[:, :] = 0.0
    for axis in range(2):
        covariance[axis, axis] = position
        covariance[3 + axis, 3 + axis] = bias
        covariance[axis, 3 + axis] = -bias
        covariance[3 + axis, axis] = -bias
    covariance[2, 2] = noise.heading_rad[profile] ** 2
    mean[0] = x_m
    mean[1] = y_m
    mean[2] = wrap_angle(heading_rad)
    mean[3] = 0.0
    mean[4] = 0.0


@inline
def process_noise(
    noise: FilterNoise[Floats], profile: int, speed_mps: float, yaw_sigma_rad: float, step_s: float
) -> tuple[float, float, float]:
    """Return the variances that a step adds along the body, across it, and to yaw.

    Along: white odometer noise, and the scale error as noise of `LASTING_ERROR_S` correlation. Across: a yaw error of
    `yaw_sigma_rad` in the same way (0 where yaw is a state of the filter).
    """
    lasting = step_s * LASTING_ERROR_S
    scale = noise.odometer_scale[profile] * speed_mps
    along = (noise.odometer_white_mps[profile] * step_s) ** 2 + scale * scale * lasting
    across = (yaw_sigma_rad * speed_mps) ** 2 * lasting
    yaw = (noise.gyro_white_rps[profile] * step_s) ** 2 + noise.gyro_bias_rps[profile] ** 2 * lasting
    return along, across, yaw


@inline
def add_along(covariance: Floats, variance: float, yaw_rad: float) -> None:
    """Add a variance of the position along a direction."""
    P = covariance
    c = cos(yaw_rad)
    s = sin(yaw_rad)
    P[0, 0] += variance * c * c
    P[0, 1] += variance * c * s
    P[1, 0] += variance * c * s
    P[1, 1] += variance * s * s


@inline
def predict_pose(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
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
    tau = noise.gnss_bias_tau_s[profile]
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
    along, _, yaw = process_noise(noise, profile, speed_mps, 0.0, step_s)
    add_along(P, along, middle)
    P[2, 2] += yaw
    fresh = noise.gnss_bias_m[profile] ** 2 * (1.0 - decay * decay)
    P[3, 3] += fresh
    P[4, 4] += fresh
    mean[0] = x
    mean[1] = y
    mean[2] = wrap_angle(mean[2] + turn)
    mean[3] *= decay
    mean[4] *= decay


def updating(states: int) -> Callable[[Floats, Floats, Floats, float, float, float], int]:
    """Return the update of a filter whose first five of five to seven `states` are those of the EKF."""

    @inline
    def update(mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float) -> int:
        """Correct with a fix, one axis after the other (their white errors are independent), and return repairs made.

        For each axis H = e_axis + e_(3+axis); S = H P Hᵀ + R, K = P Hᵀ / S, P' = P - K S Kᵀ.
        """
        P = covariance
        repairs = 0
        sixth, last = min(5, states - 1), states - 1
        for axis in range(2):
            b = 3 + axis
            S = P[axis, axis] + 2.0 * P[axis, b] + P[b, b] + white_m * white_m
            nu = (x_m if axis == 0 else y_m) - mean[axis] - mean[b]
            gain = (
                (P[0, axis] + P[0, b]) / S,
                (P[1, axis] + P[1, b]) / S,
                (P[2, axis] + P[2, b]) / S,
                (P[3, axis] + P[3, b]) / S,
                (P[4, axis] + P[4, b]) / S,
                (P[sixth, axis] + P[sixth, b]) / S,
                (P[last, axis] + P[last, b]) / S,
            )
            for i in range(states):
                mean[i] += gain[i] * nu
                for j in range(i + 1):
                    P[i, j] -= gain[i] * S * gain[j]
                    P[j, i] = P[i, j]
            innovation[axis] = nu / sqrt(S)
        mean[2] = wrap_angle(mean[2])
        for i in range(states):
            if P[i, i] < 0.0:
                P[i, i] = 0.0
                repairs += 1
        return repairs

    return update


update = updating(STATES)


@inline
def trust(mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int) -> None:
    """Make the slow GNSS error as unknown as at the start."""
    bias = noise.gnss_bias_m[profile] ** 2
    for axis in (3, 4):
        mean[axis] = 0.0
    for i in range(STATES):
        for j in range(STATES):
            if i != j and (i > 1 or j > 1):
                covariance[i, j] = 0.0
    for axis in (3, 4):
        covariance[axis, axis] = bias
