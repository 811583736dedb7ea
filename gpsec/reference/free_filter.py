"""The free filter by filterpy: dead reckoning, and the fixes that agree with it."""

from math import cos, exp, log, sin

import numpy as np
from filterpy.kalman import KalmanFilter

from gpsec.association.free import CUT, CUT_MEAN, GATE, LEARN_S, LEAST, MOST, MOST_SCALE
from gpsec.core.arrays import Floats
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.reference.filters import arc


class FreeFilter:
    """East, north and the scale error of the odometer; neither camera nor map.

    Attributes:
        accepted: fixes accepted in turn, -1 where the last one was refused.
        learnt: white variance of fixes over that of the data sheet.
    """

    def __init__(self, noise: FilterNoise[float], fix_m: Floats) -> None:
        self._noise = noise
        self._filter = KalmanFilter(dim_x=3, dim_z=2)
        self._filter.x = np.array([fix_m[0], fix_m[1], 0.0])
        position = noise.gnss_white_m**2 + noise.gnss_bias_m**2
        self._filter.P = np.diag([position, position, noise.odometer_scale**2])
        self._filter.H = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        self.accepted = 0
        self.learnt = 1.0
        self._left_over_m = np.zeros(2)

    @property
    def position_m(self) -> Floats:
        """The (2,) position."""
        return np.asarray(self._filter.x[:2])

    @property
    def scale(self) -> float:
        """The scale error that it has learnt."""
        return float(self._filter.x[2])

    @property
    def scale_variance(self) -> float:
        """Its variance."""
        return float(self._filter.P[2, 2])

    @property
    def white_variance(self) -> float:
        """Variance of the white noise of a fix, as learnt, in m²."""
        return self._noise.gnss_white_m**2 * self.learnt

    def way(self, speed_mps: float, turn_rad: float, heading_rad: float, step_s: float) -> Floats:
        """Return the (2,) way of a step by odometer and heading, less the scale error."""
        return arc(heading_rad - turn_rad, speed_mps * step_s / (1.0 + self.scale), turn_rad)

    def predict(self, speed_mps: float, turn_rad: float, heading_rad: float, step_s: float) -> None:
        """Move by a step."""
        noise, kalman = self._noise, self._filter
        way = self.way(speed_mps, turn_rad, heading_rad, step_s)
        F = np.eye(3)
        F[:2, 2] = -way
        middle = heading_rad - turn_rad / 2.0
        wander = 2.0 * noise.gnss_bias_m**2 * step_s / noise.gnss_bias_tau_s
        along = (noise.odometer_white_mps * step_s) ** 2
        across = (noise.heading_rad * speed_mps) ** 2 * step_s * LASTING_ERROR_S
        Q = np.zeros((3, 3))
        Q[:2, :2] = turned(along, across, middle) + wander * np.eye(2)
        mean = kalman.x + np.array([way[0], way[1], 0.0])
        kalman.predict(F=F, Q=Q)
        kalman.x = mean  # the way itself, not its linearisation

    def take(self, fix_m: Floats) -> None:
        """Test a fix, learn the noise of fixes, and correct by it where it is accepted."""
        kalman, noise = self._filter, self._noise
        innovation = fix_m - self.position_m
        variance = self.white_variance
        if self.accepted != 0:
            squares = (innovation - self._left_over_m) ** 2 / 2.0 / variance
            step = noise.gnss_period_s / LEARN_S / 2.0 * float(np.minimum(squares, CUT).sum() - 2.0 * CUT_MEAN)
            self.learnt = exp(min(max(log(self.learnt) + step, LEAST), MOST))
        S = kalman.P[:2, :2] + variance * np.eye(2)
        if innovation @ np.linalg.solve(S, innovation) > GATE:
            self.accepted = -1
        else:
            self.accepted = max(self.accepted, 0) + 1
            kalman.update(fix_m, R=variance * np.eye(2))
            most = MOST_SCALE * noise.odometer_scale
            if abs(self.scale) > most:
                kalman.x[2] = most if self.scale > 0.0 else -most
                kalman.P[2, 2] = max(kalman.P[2, 2], noise.odometer_scale**2)
        self._left_over_m = fix_m - self.position_m

    def doubt(self, variance: float) -> None:
        """Add to the variance of the position, in m²."""
        self._filter.P[:2, :2] += variance * np.eye(2)


def turned(along: float, across: float, yaw_rad: float) -> Floats:
    """Return the (2, 2) covariance of errors along and across a direction."""
    c, s = cos(yaw_rad), sin(yaw_rad)
    axes = np.array([[c, -s], [s, c]])
    return np.asarray(axes @ np.diag([along, across]) @ axes.T)
