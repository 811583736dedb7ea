"""The filters of `consider_ukf`: Schmidt-Kalman updates in matrices, with sigma points from filterpy."""

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints

from gpsec.core.arrays import Floats
from gpsec.reference.filters import wrapped
from gpsec.reference.learning import LaneUkf, LearningEkf, camera_white_m, way_between
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.sight import Sight

# Points at sqrt(3) standard deviations, as in the paper's UKF.
_POINTS = MerweScaledSigmaPoints(n=2, alpha=1.0, beta=2.0, kappa=1.0)


def schmidt_update(mean: Floats, P: Floats, H: Floats, nu: Floats, R: Floats, active: int) -> tuple[Floats, Floats]:
    """Return mean and covariance after (m,) innovations `nu`; only the first `active` states are corrected."""
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    K[active:] = 0.0
    kept = np.eye(len(mean)) - K @ H
    return mean + K @ nu, kept @ P @ kept.T + K @ R @ K.T


class ConsideringEkf(LearningEkf):
    """The EKF of normal operation that considers the odometer's scale error and the gyro's bias."""

    def update(self, fix_m: Floats) -> None:
        """Correct all but scale and gyro bias with a fix; sets the normalised innovation squared, `nis`."""
        ekf, H = self._filter, self._H
        nu = fix_m - H @ ekf.x
        self.nis = float(nu @ np.linalg.solve(H @ ekf.P @ H.T + ekf.R, nu))
        ekf.x, ekf.P = schmidt_update(ekf.x, ekf.P, H, nu, ekf.R, active=5)
        ekf.x[2] = wrapped(ekf.x[2])


class ConsideringUkf(LaneUkf):
    """The paper's UKF, to which yaw, scale, gyro bias and the camera's lasting errors are considered."""

    def trusting(self, widened: Floats) -> ConsideringEkf:
        """Go back to GNSS; the covariance of the position grows by (2, 2) `widened`."""
        learnt = super().trusting(widened)
        return ConsideringEkf(learnt.noise, learnt.mean, learnt.covariance)

    def update(self, matcher: LaneMatcher, sight: Sight) -> bool:
        """Correct the position with the lane offset that the camera sees; False where a sigma point has no match."""
        if sight.lane_offset_m is None:
            return False
        x, P = self.state, self.state_covariance
        points = _POINTS.sigma_points(x[:2], P[:2, :2])
        offsets = [matcher.offset(float(east), float(north), self.yaw_rad, sight.lane) for east, north in points]
        if any(offset is None for offset in offsets):
            return False
        seen = np.asarray(offsets, np.float64)
        expected = float(_POINTS.Wm @ seen)
        H = np.zeros((1, 7))
        H[0, :2] = np.linalg.solve(P[:2, :2], (points - x[:2]).T @ (_POINTS.Wc * (seen - expected)))
        H[0, 5:] = 1.0
        # What the points scatter beyond a linear observation is noise.
        beyond = float(_POINTS.Wc @ (seen - expected) ** 2 - H[0, :2] @ P[:2, :2] @ H[0, :2])
        R = np.array([[camera_white_m(self.noise, sight.camera_sigma_m) ** 2 + beyond]])
        here = float(x[0]), float(x[1]), self.yaw_rad, sight.lane
        chord, arc = matcher.offset(*here), matcher.view(*here)
        if chord is None or arc is None:
            return False
        map_variance, _ = matcher.unsure(*here, way_between(self.noise, sight.speed_mps))
        R += map_variance
        nu = np.array([sight.lane_offset_m - (expected + arc[0] - chord) - x[5:].sum()])
        self.state, self.state_covariance = schmidt_update(x, P, H, nu, R, active=2)
        return True
