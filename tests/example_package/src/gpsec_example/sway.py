"""Sway: the fix swings from one side of the lane to the other."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import DirectedAttack, NoState, Spoofed, Victims, unit_vectors


class Sway(DirectedAttack):
    """The displacement is a sine of time.

    Attributes:
        amplitude_m: largest displacement.
        period_s: of the sine.
    """

    name: ClassVar[str] = "sway"
    amplitude_m: float = Field(1.0, gt=0.0, le=100.0)
    period_s: float = Field(8.0, ge=0.5, le=600.0)

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return fix + A·sin(2π·t/T)."""
        phase = 2.0 * np.pi * victims.elapsed_s / self.period_s
        return self.displace(victims, self.amplitude_m * unit_vectors(phase)[:, 1])
