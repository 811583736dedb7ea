"""Lane alias: a displacement that moves the fix into the neighbouring lane."""

from dataclasses import dataclass
from typing import ClassVar, Literal, Self, cast

import numpy as np

from gpsec.attacks.base import Attack, Spoofed, Victims, displace_left, random_signs
from gpsec.core.arrays import Floats
from gpsec.core.tables import Rows


@dataclass
class LaneAliasState(Rows):
    """M track rows.

    Attributes:
        sign: (M,) +1 left, -1 right, 0 before the first step of the attack.
    """

    sign: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows without a side."""
        return cls(sign=np.zeros(capacity))


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
    side: Literal["adjacent", "left", "right"] = "adjacent"

    def new_state(self, capacity: int) -> LaneAliasState:
        """Return the side of each track."""
        return LaneAliasState.empty(capacity)

    def spoof(self, victims: Victims, state: Rows) -> Spoofed:
        """Return fix + side·lane width."""
        sign = cast("LaneAliasState", state).sign
        before = sign[victims.rows]
        sign[victims.rows] = np.where(before == 0.0, self._choose(victims), before)
        return displace_left(victims, sign[victims.rows] * victims.lane_width_m)

    def _choose(self, victims: Victims) -> Floats:
        if self.side != "adjacent":
            return np.full(len(victims.rows), 1.0 if self.side == "left" else -1.0)
        one_side = victims.left_lane != victims.right_lane
        return np.where(one_side, np.where(victims.left_lane, 1.0, -1.0), random_signs(victims))
