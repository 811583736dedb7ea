"""Jamming: no fix."""

from typing import ClassVar

import numpy as np

from gpsec.attacks.base import Attack, NoState, Spoofed, Victims


class Jamming(Attack):
    """The receiver is drowned in noise and gives no fix while the attack lasts."""

    name: ClassVar[str] = "jamming"

    def spoof(self, victims: Victims, state: NoState) -> Spoofed:
        """Return no fix; the honest position does not hide under the mask either."""
        return Spoofed(np.zeros_like(victims.fix_m), np.zeros_like(victims.fix_valid))
