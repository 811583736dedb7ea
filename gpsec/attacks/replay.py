"""Replay: the receiver gets the signal of a while ago."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import Attack, NoState, Spoofed, Victims


class Replay(Attack):
    """The honest signal is recorded and sent again later (meaconing): the fix of τ seconds ago.

    The receiver keeps its rate: a replayed fix arrives when an honest one would have. A vehicle that has not had a
    fix τ seconds ago gets none: the attacker's signal hides the honest one before there is anything to replay.

    Attributes:
        delay_s: τ.
    """

    name: ClassVar[str] = "replay"
    delay_s: float = Field(5.0, gt=0.0, le=120.0)

    def needed_memory_s(self) -> float:
        """Return τ."""
        return self.delay_s

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return the fix of τ seconds ago."""
        past_m, exists = victims.past_fix(self.delay_s)
        return Spoofed(np.where(exists[:, np.newaxis], past_m, 0.0), victims.fix_valid & exists)
