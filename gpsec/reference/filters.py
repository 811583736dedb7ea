"""The filters from filterpy: an EKF with GNSS, and the UKF of Eqs 11-16 without."""

from math import cos, exp, pi, sin

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

from gpsec.core.arrays import Floats
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.sight import Sight


class GnssEkf:
    """Wheel speed and yaw rate propagate, GNSS corrects.

    State: east, north, yaw, and the slow part of the GNSS error in east and north, a first-order Gauss-Markov process.
    """

    # What a fix measures: position plus slow error.
    _H = np.array([[1.0, 0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0, 1.0]])

    def __init__(self, noise: FilterNoise[float], mean: Floats, covariance: Floats) -> None:
        self.noise = noise
        self._filter = ExtendedKalmanFilter(dim_x=5, dim_z=2)
        self._filter.x, self._filter.P = mean, covariance
        self._filter.R = np.eye(2) * noise.gnss_white_m**2
        self.nis: float | None = None

    @classmethod
    def at_first_fix(cls, noise: FilterNoise[float], fix_m: Floats, heading_rad: float) -> "GnssEkf":
        """Start at a fix: position = fix - white error - slow error, so that position and slow error are correlated."""
        P = np.zeros((5, 5))
        slow = noise.gnss_bias_m**2 * np.eye(2)
        P[:2, :2] = noise.gnss_white_m**2 * np.eye(2) + slow
        P[:2, 3:] = P[3:, :2] = -slow
        P[3:, 3:] = slow
        P[2, 2] = noise.heading_rad**2
        return cls(noise, np.array([fix_m[0], fix_m[1], wrapped(heading_rad), 0.0, 0.0]), P)

    @property
    def mean(self) -> Floats:
        """The (5,) state."""
        return np.asarray(self._filter.x)

    @property
    def covariance(self) -> Floats:
        """Its (5, 5) covariance."""
        return np.asarray(self._filter.P)

    def predict(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Propagate by one step."""
        self.nis = None
        noise, ekf = self.noise, self._filter
        east, north, yaw, slow_east, slow_north = ekf.x
        shift = arc(yaw, speed_mps * step_s, yaw_rate_rps * step_s)
        decay = exp(-step_s / noise.gnss_bias_tau_s)
        ekf.F = np.diag([1.0, 1.0, 1.0, decay, decay])
        ekf.F[:2, 2] = -shift[1], shift[0]
        ekf.Q = np.zeros((5, 5))
        # Yaw is a state, so that nothing but its own uncertainty moves the vehicle across its course.
        ekf.Q[:2, :2] = position_noise(noise, yaw + yaw_rate_rps * step_s / 2.0, speed_mps, 0.0, step_s)
        ekf.Q[2, 2] = yaw_noise(noise, step_s)
        ekf.Q[3, 3] = ekf.Q[4, 4] = noise.gnss_bias_m**2 * (1.0 - decay**2)
        ekf.predict()  # P' = F P Fᵀ + Q; the mean follows the arc itself, not its linearisation
        turned = wrapped(yaw + yaw_rate_rps * step_s)
        ekf.x = np.array([east + shift[0], north + shift[1], turned, decay * slow_east, decay * slow_north])

    def update(self, fix_m: Floats) -> None:
        """Correct with a fix; sets the normalised innovation squared, `nis`."""
        ekf = self._filter
        ekf.update(fix_m, HJacobian=lambda x: self._H, Hx=lambda x: self._H @ x)
        ekf.x[2] = wrapped(ekf.x[2])
        self.nis = float(ekf.y @ ekf.SI @ ekf.y)


class PositionUkf:
    """State east and north, with yaw beside it; the camera's lane offset is observed through the HD map."""

    def __init__(
        self, noise: FilterNoise[float], position_m: Floats, covariance: Floats, yaw_rad: float, yaw_variance: float
    ) -> None:
        self._noise = noise
        points = MerweScaledSigmaPoints(n=2, alpha=1.0, beta=2.0, kappa=1.0)
        self._filter = UnscentedKalmanFilter(dim_x=2, dim_z=1, dt=0.0, hx=not_given, fx=not_given, points=points)
        self._filter.x, self._filter.P = position_m, covariance
        self.yaw_rad, self.yaw_variance = yaw_rad, yaw_variance

    @classmethod
    def isolated(cls, ekf: GnssEkf) -> "PositionUkf":
        """Start from a filter that has used GNSS."""
        mean, P = ekf.mean, ekf.covariance
        return cls(ekf.noise, mean[:2].copy(), P[:2, :2].copy(), float(mean[2]), float(P[2, 2]))

    @property
    def mean(self) -> Floats:
        """The (2,) position."""
        return np.asarray(self._filter.x)

    @property
    def covariance(self) -> Floats:
        """Its (2, 2) covariance."""
        return np.asarray(self._filter.P)

    def predict(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Move every sigma point by the same arc (Eqs 11-12) and add process noise."""
        turn = yaw_rate_rps * step_s
        shift = arc(self.yaw_rad, speed_mps * step_s, turn)
        middle = self.yaw_rad + turn / 2.0
        self._filter.Q = position_noise(self._noise, middle, speed_mps, self.yaw_variance, step_s)
        self._filter.predict(dt=step_s, fx=lambda point, dt: point + shift)
        self.yaw_rad = wrapped(self.yaw_rad + turn)
        self.yaw_variance += yaw_noise(self._noise, step_s)

    def take_yaw(self, yaw_rad: float) -> None:
        """Take the heading sensor's yaw."""
        self.yaw_rad, self.yaw_variance = yaw_rad, self._noise.heading_rad**2

    def trusting(self, widened: Floats) -> GnssEkf:
        """Go back to GNSS; the covariance of the position grows by (2, 2) `widened`."""
        P = np.diag([0.0, 0.0, self.yaw_variance, self._noise.gnss_bias_m**2, self._noise.gnss_bias_m**2])
        P[:2, :2] = self.covariance + widened
        return GnssEkf(self._noise, np.array([*self.mean, self.yaw_rad, 0.0, 0.0]), P)

    def update(self, matcher: LaneMatcher, sight: Sight) -> bool:
        """Correct with the lane offset that the camera sees (Eqs 13-16).

        Returns whether every sigma point was matched; where one was not, nothing is corrected.
        """

        def expected(point: Floats) -> Floats:
            offset = matcher.offset(float(point[0]), float(point[1]), self.yaw_rad, sight.lane)
            if offset is None:
                raise NoLaneError
            return np.array([offset])

        try:
            self._filter.update(np.array([sight.lane_offset_m]), R=sight.camera_sigma_m**2, hx=expected)
        except NoLaneError:
            return False
        return True


class NoLaneError(Exception):
    """A sigma point lies beside no lane."""


def not_given(*_: object) -> Floats:
    """Refuse to be called: filterpy is given the function with every call."""
    raise NotImplementedError("given with every call")


def arc(yaw_rad: float, length_m: float, turn_rad: float) -> Floats:
    """Return the chord (east, north) of a circular arc that begins in direction `yaw_rad`."""
    chord = length_m * float(np.sinc(turn_rad / 2.0 / pi))
    middle = yaw_rad + turn_rad / 2.0
    return chord * np.array([cos(middle), sin(middle)])


def position_noise(
    noise: FilterNoise[float], course_rad: float, speed_mps: float, yaw_variance: float, step_s: float
) -> Floats:
    """Return the (2, 2) process noise of a step: odometer noise along the course, unknown yaw across it."""
    lasting = step_s * LASTING_ERROR_S
    along = (noise.odometer_white_mps * step_s) ** 2 + (noise.odometer_scale * speed_mps) ** 2 * lasting
    across = yaw_variance * speed_mps**2 * lasting
    body = np.array([[cos(course_rad), -sin(course_rad)], [sin(course_rad), cos(course_rad)]])
    turned: Floats = body @ np.diag([along, across]) @ body.T
    return turned


def yaw_noise(noise: FilterNoise[float], step_s: float) -> float:
    """Return the variance that the gyro adds to yaw in a step."""
    return (noise.gyro_white_rps * step_s) ** 2 + noise.gyro_bias_rps**2 * step_s * LASTING_ERROR_S


def wrapped(angle_rad: float) -> float:
    """Return the same direction in [-π, π)."""
    return (angle_rad + pi) % (2.0 * pi) - pi
