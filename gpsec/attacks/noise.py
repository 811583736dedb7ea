"""Noise: every fix is thrown somewhere else."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import Attack, NoState, Spoofed, Victims
from gpsec.core import noise


class Noise(Attack):
    """Every fix is displaced by a fresh draw from a wide distribution: y + φ, φ ~ N(0, σ²) to the east and north.

    Attributes:
        sigma_m: σ, standard deviation on each axis.
    """

    name: ClassVar[str] = "noise"
    sigma_m: float = Field(3.0, gt=0.0, le=10_000.0)

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return fix + φ."""
        east = noise.normals(victims.key, noise.PLAN_ATTACK_EAST, victims.step)
        north = noise.normals(victims.key, noise.PLAN_ATTACK_NORTH, victims.step)
        return Spoofed(victims.fix_m + self.sigma_m * np.stack([east, north], axis=1), victims.fix_valid.copy())
