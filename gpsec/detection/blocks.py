"""Rows that a kernel takes together, for detectors that are faster so."""

from gpsec.core.arrays import Flags, Ints
from gpsec.core.kernels import inline


@inline
def choose(chosen: Ints, block: Ints, due: Flags, profile_of: Ints, profile: int) -> int:
    """Put the observations of one profile that are due at the front of `chosen`, and return how many there are.

    Args:
        chosen: (B,) observations, to be filled in.
        block: (b,) observations, at most B.
        due: (b,) whether each is due.
        profile_of: (m,) profile of each observation.
        profile: the one that is asked for.
    """
    count = 0
    for n in range(len(block)):
        if due[n] and profile_of[block[n]] == profile:
            chosen[count] = block[n]
            count += 1
    return count
