"""Stealth: an exponentially growing displacement (Eqs 8-9)."""

from math import log
from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import DirectedAttack, NoState, Spoofed, Victims, powers

# k of Eq 9 counts samples at 10 Hz. It is taken from the time, so that the attack is the same for every step length.
_SAMPLE_S = 0.1


class Stealth(DirectedAttack):
    """The displacement begins below the noise and grows exponentially: y + γ·δᵏ (Eqs 8-9).

    k counts tenths of a second since the attack began. With the defaults the displacement is 2 cm at the start,
    0.23 m after 5 s and 2.6 m after 10 s.

    Attributes:
        gamma_m: γ, displacement at the start.
        delta: δ, growth in a tenth of a second.
        cap_m: largest displacement.
    """

    name: ClassVar[str] = "stealth"
    gamma_m: float = Field(0.02, gt=0.0, le=10.0)
    delta: float = Field(1.05, gt=1.0, le=2.0)
    cap_m: float = Field(5.0, gt=0.0, le=10_000.0)

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return fix + min(γ·δᵏ, cap)."""
        k_at_cap = log(self.cap_m / self.gamma_m) / log(self.delta)
        k = np.minimum(victims.elapsed_s / _SAMPLE_S, k_at_cap)  # beyond it the power might overflow
        return self.displace(victims, np.minimum(self.gamma_m * powers(self.delta, k), self.cap_m))
