"""By what the sensors of a run differ from their data sheets; filters and detectors are not told."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.sensors.canyons import CANYON_SCALE
from gpsec.sensors.smooth import RATE, RATE_KICK, REACH
from gpsec.sensors.table import BIAS, KICK, UNKNOWN, WHITE, ProfileTable


@dataclass(frozen=True)
class Mismatch:
    """Factors on the standard deviations of the profiles' errors.

    Attributes:
        gnss_white: on the white noise of fixes.
        gnss_slow: on the slow error of fixes.
        camera: on noise, slow error and mounting offset; what the camera states of itself stays.
        odometer: on white noise and scale error.
        gyro: on angle random walk and bias.
        heading: on white noise and slow error.
        common_share: share of the variance of the slow error of fixes that all vehicles have in common, where their
            profile does not say.
    """

    gnss_white: float = 1.0
    gnss_slow: float = 1.0
    camera: float = 1.0
    odometer: float = 1.0
    gyro: float = 1.0
    heading: float = 1.0
    common_share: float = 0.0

    def common_shares(self, stated: ProfileTable) -> Floats:
        """Return (P,) which share of the slow error's variance all receivers have in common: the profile's, or ours."""
        return np.where(stated.common > 0.0, stated.common, self.common_share)

    def applied(self, stated: ProfileTable) -> ProfileTable:
        """Return the table of what sensors do, given that of their data sheets; without the common error."""
        table = ProfileTable(*(channel.copy() for channel in stated))
        table.gnss[:, WHITE] *= self.gnss_white
        own = self.gnss_slow * np.sqrt(1.0 - self.common_shares(stated))[:, None]
        table.gnss[:, [BIAS, KICK]] *= own
        table.wander[:, [RATE, RATE_KICK, REACH]] *= own
        table.multipath[:, CANYON_SCALE] *= self.gnss_slow
        table.camera[:, UNKNOWN] *= self.camera
        for channel, factor in (
            (table.odometer, self.odometer),
            (table.gyro, self.gyro),
            (table.heading, self.heading),
        ):
            channel[:, [WHITE, BIAS, KICK]] *= factor
        return table


AS_STATED = Mismatch()
"""Sensors are as their data sheets say."""
