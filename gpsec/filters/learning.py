"""The motion of a vehicle that learns its odometer's scale and its gyro's bias while GNSS is trusted.

State, trusting GNSS: east, north, yaw, slow GNSS error east and north, scale error of the odometer, bias of the gyro.
The slow GNSS error is there for the same reason as in the EKF, and here for another: what is drift of the receiver
would otherwise be learnt as scale. Isolated, two errors of the camera's offset take their places: its slow error that
of GNSS east, and its mounting offset, which does not change, that of GNSS north.

A lasting error is a state here, so that nothing has to stand in for it as white noise. Yaw is what the gyro has told of
it so far: that of the vehicle `gyro_latency_s` ago, since when it has turned by `lead` more.
"""

from math import exp

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.filters import ekf
from gpsec.filters.noise import FilterNoise

# Filter state: that of the EKF, scale error of the odometer (ratio) and bias of the gyro (rad/s).
LEARNING_STATES = 7
SLOW, SLOW_NORTH, SCALE, GYRO_ERROR = 3, 4, 5, 6
MOUNTING = SLOW_NORTH


@inline
def start_learning(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
) -> None:
    """Start a filter at its first fix; of scale and bias it knows the data sheet."""
    ekf.start_at_fix(mean, covariance, noise, profile, x_m, y_m, heading_rad)
    mean[SCALE] = 0.0
    mean[GYRO_ERROR] = 0.0
    covariance[SCALE, SCALE] = noise.odometer_scale[profile] ** 2
    covariance[GYRO_ERROR, GYRO_ERROR] = noise.gyro_bias_rps[profile] ** 2


@inline
def lead(noise: FilterNoise[Floats], profile: int, yaw_rate_rps: float) -> float:
    """Return by how much the vehicle has turned since the newest yaw rate was measured, if it turns on like that."""
    return float(noise.gyro_latency_s[profile] * yaw_rate_rps)


@inline
def predict_learnt(
    mean: Floats,
    covariance: Floats,
    noise: FilterNoise[Floats],
    profile: int,
    speed_mps: float,
    yaw_rate_rps: float,
    step_s: float,
    isolated: bool,
) -> None:
    """Propagate by one step: x' = f(x, u), P' = F P Fᵀ + Q, along the arc of the corrected speed and yaw rate."""
    P = covariance
    scale = 1.0 + mean[SCALE]
    distance = speed_mps * step_s / scale
    rate = yaw_rate_rps - mean[GYRO_ERROR]
    turn = rate * step_s
    course = mean[2] + lead(noise, profile, rate)
    x, y = dead_reckon(mean[0], mean[1], course, distance, turn)
    dx = x - mean[0]
    dy = y - mean[1]
    if isolated:
        slow = noise.camera_bias_m[profile] ** 2
        decay = exp(-step_s / noise.camera_bias_tau_s[profile])
        decay_north = 1.0
    else:
        slow = noise.gnss_bias_m[profile] ** 2
        decay = exp(-step_s / noise.gnss_bias_tau_s[profile])
        decay_north = decay
    keeps = exp(-step_s / noise.gyro_bias_tau_s[profile])
    # Derivatives of position by yaw, by scale and by gyro bias: half of a turn is made before the middle of the arc.
    half = 0.5 * step_s + noise.gyro_latency_s[profile]
    for j in range(LEARNING_STATES):
        P[0, j] += -dy * P[2, j] - dx / scale * P[SCALE, j] + half * dy * P[GYRO_ERROR, j]
        P[1, j] += dx * P[2, j] - dy / scale * P[SCALE, j] - half * dx * P[GYRO_ERROR, j]
        P[2, j] -= step_s * P[GYRO_ERROR, j]
        P[SLOW, j] *= decay
        P[SLOW_NORTH, j] *= decay_north
        P[GYRO_ERROR, j] *= keeps
    for i in range(LEARNING_STATES):
        P[i, 0] += -dy * P[i, 2] - dx / scale * P[i, SCALE] + half * dy * P[i, GYRO_ERROR]
        P[i, 1] += dx * P[i, 2] - dy / scale * P[i, SCALE] - half * dx * P[i, GYRO_ERROR]
        P[i, 2] -= step_s * P[i, GYRO_ERROR]
        P[i, SLOW] *= decay
        P[i, SLOW_NORTH] *= decay_north
        P[i, GYRO_ERROR] *= keeps
    along = (noise.odometer_white_mps[profile] * step_s) ** 2
    ekf.add_along(P, along, course + 0.5 * turn)
    P[2, 2] += (noise.gyro_white_rps[profile] * step_s) ** 2
    P[SLOW, SLOW] += slow * (1.0 - decay * decay)
    P[SLOW_NORTH, SLOW_NORTH] += slow * (1.0 - decay_north * decay_north)
    P[GYRO_ERROR, GYRO_ERROR] += noise.gyro_bias_rps[profile] ** 2 * (1.0 - keeps * keeps)
    mean[0] = x
    mean[1] = y
    mean[2] = wrap_angle(mean[2] + turn)
    mean[SLOW] *= decay
    mean[SLOW_NORTH] *= decay_north
    mean[GYRO_ERROR] *= keeps


update_learning = ekf.updating(LEARNING_STATES)
