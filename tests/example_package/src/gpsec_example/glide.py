"""Glide: a vehicle that goes to where it wants to be by a first-order lag."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.steering.base import LateralDynamics, LateralMotion, Moved, Nothing


class Glide(LateralDynamics):
    """The rate across the road is the distance over a time, within an angle to the road.

    Attributes:
        time_s: of the lag.
        most_slope: largest rate across the road, over the speed.
    """

    name: ClassVar[str] = "glide"
    time_s: float = Field(1.2, ge=0.2, le=10.0)
    most_slope: float = Field(0.2, gt=0.0, le=1.0)

    def move(self, motion: LateralMotion, state: Nothing) -> Moved:
        """Return where the vehicles are a step later."""
        most = self.most_slope * np.maximum(motion.speed_mps, 0.0)
        rate = np.clip((motion.wanted_m - motion.offset_m) / self.time_s, -most, most)
        return Moved(motion.offset_m + rate * motion.step_s, rate)
