"""The lane over several pictures: what was seen, moved on by odometer and gyro, and what is seen now."""

from dataclasses import dataclass, field, replace
from math import exp

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.lanes import NO_LANE, SeenLane

MEMORY_M = 15.0
"""Way over which what was seen fades to 1/e."""
# The same where the lane bends sharply: a polynomial does not say how the lane goes on for longer.
_BENT_M = 3.0


def moved_on(poly: Floats, way_m: float, turn_rad: float) -> Floats:
    """Return (4,) C0 … C3 in the frame of a vehicle that has driven `way_m` and turned, to first order."""
    c0, c1, c2, c3 = poly
    slope = c1 + way_m * (2.0 * c2 + 3.0 * c3 * way_m)
    offset = c0 + way_m * (c1 + way_m * (c2 + c3 * way_m)) - 0.5 * way_m * turn_rad
    return np.array([offset, slope - turn_rad, c2 + 3.0 * c3 * way_m, c3])


@dataclass
class LaneMemory:
    """Averages what is seen over the way driven; a picture that says nothing stays one that says nothing.

    Attributes:
        length_m: way over which it fades, but for sharp bends.
    """

    length_m: float = MEMORY_M
    _kept: SeenLane = field(default=NO_LANE, init=False)
    _seen: int = field(default=0, init=False)
    _blind_m: float = field(default=0.0, init=False)

    def take(self, seen: SeenLane, moved: tuple[float, float] | None) -> SeenLane:
        """Return the lane by this picture and those before it; `moved` is the way and the turn since the last one."""
        if moved is None:
            self._seen = 0
        elif self._seen:
            self._kept = replace(self._kept, poly=moved_on(self._kept.poly, *moved))
        self._blind_m = 0.0 if seen.valid else self._blind_m + (0.0 if moved is None else moved[0])
        if self._blind_m > self.length_m:
            self._seen = 0
        if not seen.valid:
            return seen
        if self._seen and abs(seen.poly[0] - self._kept.poly[0]) > 0.5 * seen.width_m:
            self._seen = 0  # it is the next lane
        self._seen += 1
        length_m = min(self.length_m, _BENT_M) if seen.bends else self.length_m
        share = 1.0 if moved is None else 1.0 - exp(-moved[0] / length_m)
        share = max(share, 1.0 / self._seen)
        kept = self._kept
        self._kept = SeenLane(
            (1.0 - share) * kept.poly + share * seen.poly,
            (1.0 - share) * kept.width_m + share * seen.width_m,
            (1.0 - share) * kept.sigma_m + share * seen.sigma_m,  # paint errs alike from one picture to the next
            True,
            seen.bends,
        )
        return self._kept
