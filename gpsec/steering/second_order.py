"""A second-order lag: the dynamics of a lane-keeping vehicle in four operations."""

from math import radians, sin
from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.steering.base import LateralDynamics, LateralMotion, Moved, Nothing

# Between these speeds the bandwidth falls, to this share of it.
_FAST_MPS, _SLOW_MPS, _SLOW_SHARE = 10.0, 3.0, 0.625
# Slower vehicles do not move across the road.
_STANDING_MPS = 0.5


class SecondOrder(LateralDynamics):
    """A critically damped lag with bounded acceleration and heading.

    a = clip(ω²(w − y) − 2ωẏ), with y the displacement, w the one that is wanted. Checked against the single-track model
    of CommonRoad (Althoff, Koschi and Manzinger, IV 2017) under the control law of Stanley; below 4 m/s with metres of
    error it is too fast.

    Attributes:
        bandwidth_rps: ω at 10 m/s and more; it falls to five eighths of it at 3 m/s.
        lateral_accel_mps2: largest acceleration across the road.
        heading_deg: largest angle to the road.
    """

    name: ClassVar[str] = "second_order"
    bandwidth_rps: float = Field(1.6, gt=0.0, le=10.0)
    lateral_accel_mps2: float = Field(3.0, gt=0.0, le=15.0)
    heading_deg: float = Field(15.0, gt=0.0, le=60.0)

    def move(self, motion: LateralMotion, state: Nothing) -> Moved:
        """Return the next offsets and rates."""
        fast = np.clip((motion.speed_mps - _SLOW_MPS) / (_FAST_MPS - _SLOW_MPS), 0.0, 1.0)
        omega = self.bandwidth_rps * (_SLOW_SHARE + (1.0 - _SLOW_SHARE) * fast)
        pull = omega * omega * (motion.wanted_m - motion.offset_m) - 2.0 * omega * motion.rate_mps
        pull = np.clip(pull, -self.lateral_accel_mps2, self.lateral_accel_mps2)
        most = np.maximum(motion.speed_mps, 0.0) * sin(radians(self.heading_deg))
        rate = np.clip(motion.rate_mps + pull * motion.step_s, -most, most)
        rate = np.where(motion.speed_mps < _STANDING_MPS, 0.0, rate)
        return Moved(motion.offset_m + rate * motion.step_s, rate)
