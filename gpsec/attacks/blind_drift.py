"""Blind drift: a displacement that grows only where the victim's camera sees no lane."""

from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from gpsec.attacks.base import DirectedAttack, Spoofed, Victims
from gpsec.core.arrays import Floats
from gpsec.core.tables import blank


class BlindDriftState(NamedTuple):
    """What was done to M tracks.

    Attributes:
        moved_m: (M,) displacement so far.
    """

    moved_m: Floats = blank(0.0)


class BlindDrift(DirectedAttack):
    """The displacement grows by r in a second inside junctions, where no camera checks it, and stays elsewhere.

    Attributes:
        rate_mps: r, growth of the displacement while the camera is blind.
        cap_m: largest displacement.
    """

    name: ClassVar[str] = "blind_drift"
    state: ClassVar[type[Any]] = BlindDriftState
    rate_mps: float = Field(0.2, gt=0.0, le=10.0)
    cap_m: float = Field(10.0, gt=0.0, le=10_000.0)

    def spoof(self, victims: Victims, state: BlindDriftState) -> Spoofed:
        """Return fix + min(r·t, cap), where t counts the time for which the camera was blind."""
        grown = np.where(victims.blind, self.rate_mps * victims.step_s, 0.0)
        state.moved_m[victims.rows] = np.minimum(state.moved_m[victims.rows] + grown, self.cap_m)
        return self.displace(victims, state.moved_m[victims.rows])
