"""The filter of a track's monitor, from filterpy."""

from math import cos, exp, sin

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.reference.filters import arc
from gpsec.reference.learning import LearningEkf


class MonitorEkf(LearningEkf):
    """The filter that learns scale and gyro bias, which can stand, and say what it expects of a fix."""

    uneven = False

    def move(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Take a step, or stand."""
        white = max(self.noise.gyro_white_rps**2, 1e-12)
        turns = (yaw_rate_rps - self._filter.x[6]) ** 2 >= 16.0 * (self._filter.P[6, 6] + white)
        if abs(speed_mps) < max(0.03, 2.0 * self.noise.odometer_white_mps) and not turns:
            self.stand(speed_mps, yaw_rate_rps, step_s)
        else:
            self.predict(speed_mps, yaw_rate_rps, step_s)

    def stand(self, speed_mps: float, yaw_rate_rps: float, step_s: float) -> None:
        """Take a step without a turn; the gyro measures its own bias."""
        noise, ekf = self.noise, self._filter
        slow, gyro = exp(-step_s / noise.gnss_bias_tau_s), exp(-step_s / noise.gyro_bias_tau_s)
        ekf.F = np.diag([1.0, 1.0, 1.0, slow, slow, 1.0, gyro])
        fresh = noise.gnss_bias_m**2 * (1.0 - slow**2)
        ekf.Q = np.diag([0.0, 0.0, 0.0, fresh, fresh, 0.0, noise.gyro_bias_rps**2 * (1.0 - gyro**2)])
        ahead = arc(float(ekf.x[2]), 1.0, 0.0)
        ekf.Q[:2, :2] = (noise.odometer_white_mps * step_s) ** 2 * np.outer(ahead, ahead)
        ekf.predict()
        ekf.x[:2] += speed_mps * step_s * ahead
        only_gyro = np.eye(7)[6:]
        # An update of one state: filterpy's is for the two of a fix.
        S = ekf.P[6, 6] + max(noise.gyro_white_rps**2, 1e-12)
        gain = ekf.P @ only_gyro.T / S
        ekf.x = ekf.x + gain[:, 0] * (yaw_rate_rps - ekf.x[6])
        ekf.P = (np.eye(7) - gain @ only_gyro) @ ekf.P

    def expected(self, fix_m: Floats, white: float) -> tuple[Floats, Floats]:
        """Return the (2,) innovation of a fix and its (2, 2) covariance, along and across the vehicle."""
        yaw = float(self._filter.x[2])
        turn = np.array([[cos(yaw), sin(yaw)], [-sin(yaw), cos(yaw)]])
        return turn @ (fix_m - self.expected_fix_m), turn @ self.fix_covariance(white) @ turn.T

    @property
    def expected_fix_m(self) -> Floats:
        """The (2,) fix that is expected."""
        return np.asarray(self._H @ self._filter.x)

    def fix_covariance(self, white: float) -> Floats:
        """Return the (2, 2) covariance of a fix whose white error has a variance, east and north."""
        return np.asarray(self._H @ self._filter.P @ self._H.T + white * np.eye(2))

    def correct(self, fix_m: Floats, white: float) -> None:
        """Use a fix whose white error has the variance `white`."""
        self._filter.R = np.eye(2) * white
        self.update(fix_m)

    def widen(self, variance: float) -> None:
        """Make the position less sure."""
        self._filter.P[:2, :2] += variance * np.eye(2)
