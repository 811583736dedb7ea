"""Drift: a linearly growing displacement."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import DirectedAttack, NoState, Spoofed, Victims


class Drift(DirectedAttack):
    """The displacement grows by the same length every second: y + r·t.

    Attributes:
        rate_mps: r, growth of the displacement.
        cap_m: largest displacement.
    """

    name: ClassVar[str] = "drift"
    rate_mps: float = Field(0.2, ge=0.001, le=0.5)
    cap_m: float = Field(10.0, gt=0.0, le=10_000.0)

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return fix + min(r·t, cap)."""
        return self.displace(victims, np.minimum(self.rate_mps * victims.elapsed_s, self.cap_m))
