"""What an encounter is: who met whom, in which direction, and how much braking it would take."""

from enum import IntEnum

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.encounters.pairs import ClosePairs
from gpsec.encounters.rectangles import Bodies

# Both are customary limits of a conflict (SUMO's SSM device has 3 s and 3 m/s² as its defaults, which find far more).
CRITICAL_TTC_S, CRITICAL_DRAC_MPS2 = 1.5, 3.4
# Of the angle between two courses: within 45° of one direction, or of the opposite one.
_SAME_COS = 0.7


class Kind(IntEnum):
    """How two vehicles hit each other."""

    SAME = 0
    CROSSING = 1
    ONCOMING = 2
    WRECK = 3


def directions(bodies: Bodies, pairs: ClosePairs) -> Ints:
    """Return the (C,) `Kind` of each pair, by the directions of the two bodies alone."""
    i, j = pairs.first, pairs.second
    cosine = bodies.ux[i] * bodies.ux[j] + bodies.uy[i] * bodies.uy[j]
    kinds = np.full(len(i), Kind.CROSSING, np.int32)
    kinds[cosine > _SAME_COS] = Kind.SAME
    kinds[cosine < -_SAME_COS] = Kind.ONCOMING
    return kinds


def needed_braking(pairs: ClosePairs) -> Floats:
    """Return the (C,) DRAC: constant deceleration that would avoid the contact; 0 where they touch already.

    With a gap of v·t, closing speed v and t the time to collision, it is v²/(2·v·t) = v/(2·t).
    """
    ahead = pairs.contact_s > 0.0
    return np.where(ahead, pairs.closing_mps / (2.0 * np.where(ahead, pairs.contact_s, 1.0)), 0.0)
