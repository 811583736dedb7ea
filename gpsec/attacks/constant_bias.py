"""Constant bias (Eq 7)."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import DirectedAttack, NoState, Spoofed, Victims


class ConstantBias(DirectedAttack):
    """Every fix is displaced by the same vector: y + c (Eq 7).

    Attributes:
        bias_m: length of the displacement.
    """

    name: ClassVar[str] = "constant_bias"
    bias_m: float = Field(2.4, gt=0.0, le=10_000.0)

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return fix + c."""
        return self.displace(victims, np.full(len(victims.rows), self.bias_m))
