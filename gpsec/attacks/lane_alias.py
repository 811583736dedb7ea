"""Lane alias: a displacement that moves the fix into the neighbouring lane."""

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from gpsec.attacks.base import Attack, Spoofed, Victims, displace_left, random_signs
from gpsec.core.arrays import Floats
from gpsec.core.tables import blank


class LaneAliasState(NamedTuple):
    """The side of M tracks.

    Attributes:
        sign: (M,) +1 left, -1 right, 0 before the first step of the attack.
    """

    sign: Floats = blank(0.0)


class LaneAlias(Attack):
    """Every fix is displaced sideways by exactly the width of the lane that the vehicle is on.

    Matching to the nearest lane then finds the neighbour, at the same offset from its centre: the lateral residual
    stays small although the vehicle is believed to be a lane further.

    Attributes:
        side: `adjacent` goes to the side that has a lane, of either direction, when the attack begins, and to a
            random one where both or neither have; the side is kept when the vehicle changes lanes. `left` and `right`
            do not ask for a lane.
    """

    name: ClassVar[str] = "lane_alias"
    state: ClassVar[type[Any]] = LaneAliasState
    side: Literal["adjacent", "left", "right"] = "adjacent"

    def spoof(self, victims: Victims, state: LaneAliasState) -> Spoofed:
        """Return fix + side·lane width."""
        before = state.sign[victims.rows]
        sign = np.where(before == 0.0, self._choose(victims), before)
        state.sign[victims.rows] = sign
        return displace_left(victims, sign * victims.lane_width_m)

    def _choose(self, victims: Victims) -> Floats:
        if self.side != "adjacent":
            return np.full(len(victims.rows), 1.0 if self.side == "left" else -1.0)
        one_side = victims.left_lane != victims.right_lane
        return np.where(one_side, np.where(victims.left_lane, 1.0, -1.0), random_signs(victims))
