"""A filter that learns its odometer's scale and its gyro's bias while GNSS is trusted.

State, trusting GNSS: east, north, yaw, slow GNSS error east and north, scale error of the odometer, bias of the gyro.
The slow GNSS error is there for the same reason as in the EKF of the other responses, and here for another: what is
drift of the receiver would otherwise be learnt as scale. Isolated, the slow error of the camera's offset takes the
place of that of GNSS east; that of GNSS north is not used.

A lasting error is a state here, so that nothing has to stand in for it as white noise.
"""

from math import cos, exp, sin, sqrt

from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline
from gpsec.localization import ekf
from gpsec.localization.noise import FilterNoise
from gpsec.localization.ukf import YAW_SIGMAS

# Filter state: that of the EKF, scale error of the odometer (ratio) and bias of the gyro (rad/s).
LEARNING_STATES = 7
SLOW, SLOW_NORTH, SCALE, GYRO = 3, 4, 5, 6


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
    """Start a filter at its first fix; of scale and bias it knows the data sheet."""
    ekf.start(mean, covariance, table, profile, x_m, y_m, heading_rad)
    mean[SCALE] = 0.0
    mean[GYRO] = 0.0
    covariance[SCALE, SCALE] = table.odometer_scale[profile] ** 2
    covariance[GYRO, GYRO] = table.gyro_bias_rps[profile] ** 2


@inline
def predict(
    mean: Floats,
    covariance: Floats,
    table: FilterNoise[Floats],
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
    turn = (yaw_rate_rps - mean[GYRO]) * step_s
    x, y = dead_reckon(mean[0], mean[1], mean[2], distance, turn)
    dx = x - mean[0]
    dy = y - mean[1]
    if isolated:
        # The bias fades, the mounting offset does not: this is how their sum is correlated over a step.
        slow = table.camera_bias_m[profile] ** 2 + table.camera_mount_m[profile] ** 2
        fades = table.camera_bias_m[profile] ** 2 / slow if slow > 0.0 else 0.0
        decay = 1.0 - fades * (1.0 - exp(-step_s / table.camera_bias_tau_s[profile]))
    else:
        slow = table.gnss_bias_m[profile] ** 2
        decay = exp(-step_s / table.gnss_bias_tau_s[profile])
    keeps = exp(-step_s / table.gyro_bias_tau_s[profile])
    # Derivatives of position by yaw, by scale and by gyro bias: half of a turn is made before the middle of the arc.
    half = 0.5 * step_s
    for j in range(LEARNING_STATES):
        P[0, j] += -dy * P[2, j] - dx / scale * P[SCALE, j] + half * dy * P[GYRO, j]
        P[1, j] += dx * P[2, j] - dy / scale * P[SCALE, j] - half * dx * P[GYRO, j]
        P[2, j] -= step_s * P[GYRO, j]
        P[SLOW, j] *= decay
        P[SLOW_NORTH, j] *= decay
        P[GYRO, j] *= keeps
    for i in range(LEARNING_STATES):
        P[i, 0] += -dy * P[i, 2] - dx / scale * P[i, SCALE] + half * dy * P[i, GYRO]
        P[i, 1] += dx * P[i, 2] - dy / scale * P[i, SCALE] - half * dx * P[i, GYRO]
        P[i, 2] -= step_s * P[i, GYRO]
        P[i, SLOW] *= decay
        P[i, SLOW_NORTH] *= decay
        P[i, GYRO] *= keeps
    along = (table.odometer_white_mps[profile] * step_s) ** 2
    c = cos(mean[2] + 0.5 * turn)
    s = sin(mean[2] + 0.5 * turn)
    P[0, 0] += along * c * c
    P[0, 1] += along * c * s
    P[1, 0] += along * c * s
    P[1, 1] += along * s * s
    P[2, 2] += (table.gyro_white_rps[profile] * step_s) ** 2
    P[SLOW, SLOW] += slow * (1.0 - decay * decay)
    if not isolated:
        P[SLOW_NORTH, SLOW_NORTH] += slow * (1.0 - decay * decay)
    P[GYRO, GYRO] += table.gyro_bias_rps[profile] ** 2 * (1.0 - keeps * keeps)
    mean[0] = x
    mean[1] = y
    mean[2] = wrap_angle(mean[2] + turn)
    mean[SLOW] *= decay
    mean[SLOW_NORTH] *= decay
    mean[GYRO] *= keeps


@inline
def update(mean: Floats, covariance: Floats, innovation: Floats, x_m: float, y_m: float, white_m: float) -> int:
    """Correct with a fix, one axis after the other, as `ekf.update` does, and return repairs made."""
    P = covariance
    repairs = 0
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
            (P[5, axis] + P[5, b]) / S,
            (P[6, axis] + P[6, b]) / S,
        )
        for i in range(LEARNING_STATES):
            mean[i] += gain[i] * nu
            for j in range(i + 1):
                P[i, j] -= gain[i] * S * gain[j]
                P[j, i] = P[i, j]
        innovation[axis] = nu / sqrt(S)
    mean[2] = wrap_angle(mean[2])
    for i in range(LEARNING_STATES):
        if P[i, i] < 0.0:
            P[i, i] = 0.0
            repairs += 1
    return repairs


@inline
def isolate(mean: Floats, covariance: Floats, table: FilterNoise[Floats], profile: int) -> None:
    """Put the camera's slow error, of which nothing is known yet, in the place of that of GNSS."""
    for axis in (SLOW, SLOW_NORTH):
        mean[axis] = 0.0
        for i in range(LEARNING_STATES):
            covariance[axis, i] = 0.0
            covariance[i, axis] = 0.0
    covariance[SLOW, SLOW] = table.camera_bias_m[profile] ** 2 + table.camera_mount_m[profile] ** 2


@inline
def drop_polluted_yaw(mean: Floats, covariance: Floats, heading_rad: float, sigma_rad: float) -> None:
    """Take the heading sensor's yaw as `ukf.drop_polluted_yaw` does; it knows nothing of the other states."""
    if abs(wrap_angle(mean[2] - heading_rad)) <= YAW_SIGMAS * sigma_rad:
        return
    mean[2] = heading_rad
    for i in range(LEARNING_STATES):
        covariance[2, i] = 0.0
        covariance[i, 2] = 0.0
    covariance[2, 2] = sigma_rad * sigma_rad


@inline
def trust_again(mean: Floats, covariance: Floats, table: FilterNoise[Floats], profile: int) -> None:
    """Put the slow GNSS error back, as unknown as at the start; scale and bias stay learnt."""
    isolate(mean, covariance, table, profile)
    covariance[SLOW, SLOW] = table.gnss_bias_m[profile] ** 2
    covariance[SLOW_NORTH, SLOW_NORTH] = table.gnss_bias_m[profile] ** 2
