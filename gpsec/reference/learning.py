"""The filters of `ukf5` from filterpy: an EKF that learns scale and gyro bias, and a UKF of offset and direction."""

from math import cos, exp, log, sin, sqrt, tan

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, unscented_transform

from gpsec.core.arrays import Floats
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.localization.learning import BODY_AXLE_M
from gpsec.reference.filters import arc, wrapped
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.sight import Sight

# Where the learnt motion's states (east, north, yaw, scale, gyro bias) are in the state of each filter.
_IN_EKF = [0, 1, 2, 5, 6]
_IN_UKF = [0, 1, 2, 3, 4]


class LearningEkf:
    """State: east, north, yaw, slow GNSS error east and north, scale error of the odometer, bias of the gyro."""

    # Whether it allows for a body that does not turn evenly within a step.
    uneven = True
    _H = np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]])

    def __init__(self, noise: FilterNoise[float], mean: Floats, covariance: Floats) -> None:
        self.noise = noise
        self._filter = ExtendedKalmanFilter(dim_x=7, dim_z=2)
        self._filter.x, self._filter.P = mean, covariance
        self._filter.R = np.eye(2) * noise.gnss_white_m**2
        self.nis: float | None = None

    @classmethod
    def at_first_fix(cls, noise: FilterNoise[float], fix_m: Floats, heading_rad: float) -> "LearningEkf":
        """Start at a fix; position and slow error are correlated, of scale and bias the data sheet is known."""
        slow, white = noise.gnss_bias_m**2, noise.gnss_white_m**2
        P = np.diag([white + slow, white + slow, noise.heading_rad**2, slow, slow, 0.0, 0.0])
        P[[0, 1, 3, 4], [3, 4, 0, 1]] = -slow
        P[5, 5], P[6, 6] = noise.odometer_scale**2, noise.gyro_bias_rps**2
        return cls(noise, np.array([*fix_m, wrapped(heading_rad), 0.0, 0.0, 0.0, 0.0]), P)

    @property
    def mean(self) -> Floats:
        """The (7,) state."""
        return np.asarray(self._filter.x)

    @property
    def covariance(self) -> Floats:
        """Its (7, 7) covariance."""
        return np.asarray(self._filter.P)

    def predict(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Propagate by one step."""
        self.nis = None
        noise, ekf = self.noise, self._filter
        moved, F, Q = learnt_motion(noise, ekf.x[_IN_EKF], speed_mps, yaw_rate_rps, step_s)
        decay = exp(-step_s / noise.gnss_bias_tau_s)
        ekf.F = np.eye(7) * decay
        ekf.F[np.ix_(_IN_EKF, _IN_EKF)] = F
        ekf.Q = np.eye(7) * noise.gnss_bias_m**2 * (1.0 - decay**2)
        ekf.Q[np.ix_(_IN_EKF, _IN_EKF)] = Q
        if self.uneven:
            ekf.Q[:2, :2] += uneven_turn(noise, ekf.x[_IN_EKF], speed_mps, yaw_rate_rps, step_s)
        slow = decay * ekf.x[3:5]
        ekf.predict()
        ekf.x = np.array([*moved[:3], *slow, *moved[3:]])

    def update(self, fix_m: Floats) -> None:
        """Correct with a fix; sets the normalised innovation squared, `nis`."""
        ekf = self._filter
        ekf.update(fix_m, HJacobian=lambda x: self._H, Hx=lambda x: self._H @ x)
        ekf.x[2] = wrapped(ekf.x[2])
        self.nis = float(ekf.y @ ekf.SI @ ekf.y)


class GatedEkf(LearningEkf):
    """It refuses fixes that contradict it, by themselves or together with those before.

    Attributes:
        learnt: logarithm of the factor by which the white variance of fixes is larger than that of the data sheet.
    """

    _FORGETS = (0.0, 0.6, 0.85, 0.95)
    _GATE = 16.0
    # Older samples weigh less than 1e-9.
    _SAMPLES = 450

    def __init__(self, noise: FilterNoise[float], mean: Floats, covariance: Floats) -> None:
        super().__init__(noise, mean, covariance)
        self._whitened: list[Floats] = []
        # The covariance of the whitened innovations of each axis, and how many were refused since a fix was used.
        self._together = [np.zeros((0, 0)), np.zeros((0, 0))]
        self._refused = 0
        self.learnt = 0.0

    def update(self, fix_m: Floats) -> None:
        """Correct with a fix, unless it is refused; `nis` is set in any case."""
        ekf = self._filter
        ekf.R = np.eye(2) * self.noise.gnss_white_m**2 * exp(self.learnt)
        root = np.linalg.cholesky(self._H @ ekf.P @ self._H.T + ekf.R)
        new = np.linalg.solve(root, fix_m - self._H @ ekf.x)
        squares, means = self._sums()
        best = int(np.argmax(squares))
        if squares[best] > self._GATE and means[best] @ new - means[best] @ means[best] / 2.0 < -3.0:
            self._whitened.clear()
            self._refused = 0
        self._take(new, 1.0 - ekf.R[0, 0] / np.diag(root) ** 2)
        most = max(self._sums()[0])
        if most < self._GATE / 2.0:
            excess = float(np.minimum(new**2, 6.0).sum()) - 2.0 * 0.9384
            gain = self.noise.gnss_period_s / 40.0
            self.learnt = float(np.clip(self.learnt + gain * excess, log(0.7), log(2.5)))
        if most > self._GATE:
            self.nis = float(new @ new)
            self._refused += 1
        else:
            self._refused = 0
            super().update(fix_m)

    def _take(self, new: Floats, shared: Floats) -> None:
        """Take a whitened innovation; with those refused before it, it shares a part of its variance on each axis."""
        kept = len(self._whitened)
        since = max(kept - self._refused, 0)
        self._whitened = [*self._whitened, new][-self._SAMPLES :]
        for axis, part in enumerate(shared):
            matrix = np.eye(kept + 1)
            matrix[:kept, :kept] = self._together[axis][:kept, :kept]
            matrix[kept, since:kept] = matrix[since:kept, kept] = part
            self._together[axis] = matrix[-self._SAMPLES :, -self._SAMPLES :]

    def _sums(self) -> tuple[list[float], list[Floats]]:
        """Return, for each λ, the square of Σ λʲ w over its variance, and the mean Σ λʲ w / Σ λʲ."""
        if not self._whitened:
            return [0.0], [np.zeros(2)]
        samples, ages = np.array(self._whitened), np.arange(len(self._whitened))[::-1]
        squares, means = [], []
        for decay in self._FORGETS:
            weights = decay**ages
            total = weights @ samples
            variance = np.array([weights @ matrix @ weights for matrix in self._together])
            squares.append(float((total**2 / variance).sum()))
            means.append(total / weights.sum())
        return squares, means


class LaneUkf:
    """State: east, north, yaw, scale of the odometer, bias of the gyro, slow error and mounting of the camera.

    Attributes:
        state: (7,) it.
        state_covariance: (7, 7) its covariance.
    """

    # Of position and yaw, in which alone what is seen is not linear.
    _POINTS = MerweScaledSigmaPoints(n=3, alpha=1.0, beta=2.0, kappa=0.0)

    def __init__(self, noise: FilterNoise[float], state: Floats, covariance: Floats) -> None:
        self.noise = noise
        self.state, self.state_covariance = state, covariance

    @classmethod
    def isolated(cls, ekf: LearningEkf) -> "LaneUkf":
        """Start from a filter that has used GNSS; the camera's errors are unknown."""
        noise = ekf.noise
        P = np.zeros((7, 7))
        P[:5, :5] = ekf.covariance[np.ix_(_IN_EKF, _IN_EKF)]
        P[5, 5], P[6, 6] = noise.camera_bias_m**2, noise.camera_mount_m**2
        return cls(noise, np.array([*ekf.mean[_IN_EKF], 0.0, 0.0]), P)

    def trusting(self, widened: Floats) -> LearningEkf:
        """Go back to GNSS; the covariance of the position grows by (2, 2) `widened`."""
        P = np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]) * self.noise.gnss_bias_m**2
        P[np.ix_(_IN_EKF, _IN_EKF)] = self.state_covariance[:5, :5]
        P[:2, :2] += widened
        mean = np.zeros(7)
        mean[_IN_EKF] = self.state[:5]
        return LearningEkf(self.noise, mean, P)

    @property
    def mean(self) -> Floats:
        """The (2,) position."""
        return self.state[:2]

    @property
    def covariance(self) -> Floats:
        """Its (2, 2) covariance."""
        return self.state_covariance[:2, :2]

    @property
    def yaw_rad(self) -> float:
        """Yaw."""
        return float(self.state[2])

    def take_yaw(self, yaw_rad: float) -> None:
        """Take the heading sensor's yaw, which knows nothing of the other states."""
        self.state[2] = yaw_rad
        self.state_covariance[2, :] = self.state_covariance[:, 2] = 0.0
        self.state_covariance[2, 2] = self.noise.heading_rad**2

    def predict(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Propagate by one step, as the EKF is: x' = f(x, u), P' = F P Fᵀ + Q."""
        noise, state = self.noise, self.state
        moved, F, Q = learnt_motion(noise, state[_IN_UKF], speed_mps, yaw_rate_rps, step_s)
        fades = exp(-step_s / noise.camera_bias_tau_s)
        whole_F = np.diag([0.0, 0.0, 0.0, 0.0, 0.0, fades, 1.0])
        whole_Q = np.diag([0.0, 0.0, 0.0, 0.0, 0.0, noise.camera_bias_m**2 * (1.0 - fades**2), 0.0])
        whole_F[:5, :5], whole_Q[:5, :5] = F, Q
        whole_Q[:2, :2] += uneven_turn(noise, state[_IN_UKF], speed_mps, yaw_rate_rps, step_s)
        self.state = np.array([*moved, fades * state[5], state[6]])
        self.state_covariance = whole_F @ self.state_covariance @ whole_F.T + whole_Q

    def update(self, matcher: LaneMatcher, sight: Sight) -> bool:
        """Correct with offset and slope of the lane that the camera sees; False where a sigma point has no match."""
        noise = self.noise
        white = camera_white_m(noise, sight.camera_sigma_m)
        slope_sigma = noise.camera_slope * (white / noise.camera_white_m) ** 3
        mean, P = self.state, self.state_covariance
        east, north, yaw, _, gyro, slow, mount = mean.tolist()
        lead = noise.gyro_latency_s * (sight.yaw_rate_rps - gyro)
        points = self._POINTS.sigma_points(mean[:3], P[:3, :3])
        views = [matcher.view(float(x), float(y), float(angle) + lead, sight.lane) for x, y, angle in points]
        seen = np.array([[view[0], tan(view[1])] for view in views if view is not None])
        if len(seen) < len(points):
            return False
        expected, spread = unscented_transform(seen, self._POINTS.Wm, self._POINTS.Wc)
        H = np.zeros((2, 7))
        H[:, :3] = np.linalg.solve(P[:3, :3], (points - mean[:3]).T @ (self._POINTS.Wc[:, None] * (seen - expected))).T
        # The camera's errors add to the offset.
        H[0, 5:] = 1.0
        # What the points scatter beyond a linear observation is noise, and so is what the map leaves open.
        beyond = spread - H[:, :3] @ P[:3, :3] @ H[:, :3].T
        unsure = matcher.unsure(east, north, yaw + lead, sight.lane, way_between(noise, sight.speed_mps))
        both = -noise.camera_slope_correlation * white * slope_sigma
        R = np.array([[white**2, both], [both, slope_sigma**2]]) + np.diag(unsure) + beyond
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        nu = np.array([sight.lane_offset_m, sight.lane_slope]) - expected - np.array([slow + mount, 0.0])
        self.state = mean + K @ nu
        self.state[2] = wrapped(self.state[2])
        self.state_covariance = P - K @ (H @ P @ H.T + R) @ K.T
        return True


def learnt_motion(
    noise: FilterNoise[float], state: Floats, speed_mps: float, yaw_rate_rps: float, step_s: float
) -> tuple[Floats, Floats, Floats]:
    """Return the (5,) state (east, north, yaw, scale, gyro bias) after a step, its Jacobian and the process noise."""
    east, north, yaw, scale, gyro = state.tolist()
    turn = (yaw_rate_rps - gyro) * step_s
    # Yaw is that of the time of the newest yaw rate; until now the vehicle has turned on.
    course = yaw + noise.gyro_latency_s * (yaw_rate_rps - gyro)
    shift = arc(course, speed_mps * step_s / (1.0 + scale), turn)
    across = np.array([-shift[1], shift[0]])
    keeps = exp(-step_s / noise.gyro_bias_tau_s)
    F = np.eye(5)
    F[:2, 2] = across
    F[:2, 3] = -shift / (1.0 + scale)
    # A bias turns the chord by half of what it turns the vehicle.
    F[:2, 4] = -(0.5 * step_s + noise.gyro_latency_s) * across
    F[2, 4] = -step_s
    F[4, 4] = keeps
    middle = np.array([cos(course + turn / 2.0), sin(course + turn / 2.0)])
    Q = np.zeros((5, 5))
    Q[:2, :2] = (noise.odometer_white_mps * step_s) ** 2 * np.outer(middle, middle)
    Q[2, 2] = (noise.gyro_white_rps * step_s) ** 2
    Q[4, 4] = noise.gyro_bias_rps**2 * (1.0 - keeps**2)
    moved = np.array([east + shift[0], north + shift[1], wrapped(yaw + turn), scale, keeps * gyro])
    return moved, F, Q


def uneven_turn(
    noise: FilterNoise[float], state: Floats, speed_mps: float, yaw_rate_rps: float, step_s: float
) -> Floats:
    """Return the (2, 2) covariance that a step adds: its way points along yaw + θ (1/2 + d/12L), not yaw + θ/2."""
    _, _, yaw, scale, gyro = state.tolist()
    turn = (yaw_rate_rps - gyro) * step_s
    course = yaw + noise.gyro_latency_s * (yaw_rate_rps - gyro) + turn / 2.0
    beside = turn * (speed_mps * step_s / (1.0 + scale)) ** 2 / (12.0 * BODY_AXLE_M)
    left = np.array([-sin(course), cos(course)])
    return np.asarray(beside**2 * LASTING_ERROR_S / step_s * np.outer(left, left))


def way_between(noise: FilterNoise[float], speed_mps: float) -> float:
    """Return the way from one camera sample to the next, of a vehicle that creeps at least."""
    return max(abs(speed_mps), 0.03) * noise.camera_period_s


def camera_white_m(noise: FilterNoise[float], stated_m: float) -> float:
    """Return σ of the white part of the camera's offset, from the σ that it states for all of it."""
    slow = noise.camera_bias_m**2 + noise.camera_mount_m**2
    return max(sqrt(max(stated_m**2 - slow, 0.0)), noise.camera_white_m)
