"""What the monitor tells detectors, beside the residual."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.core.tables import Table, blank


class Channels(NamedTuple):
    """What the monitor says of m tracks in a step; all is 0 and False in a run of which no detector reads it.

    While nobody attacks, `along`, `across` and `camera` are nearly independent, of mean 0 and variance 1.

    Attributes:
        tested: (m,) a fix was tested in this step, at most ten times a second; the statistics stand.
        along, across: (m,) innovation of the fix along the vehicle, and across it given that along, in standard
            deviations; 0 where none was tested.
        camera: (m,) residual less its slow part, in standard deviations; 0 where there is no residual.
        blind: (m,) no lane has been in view for a while: each fix is tested for itself, and not used.
        fix_age_s: (m,) time since the last fix.
        joint: (m,) statistic of all channels.
        innovation: (m,) statistic of the innovations alone.
        separation: (m,) statistic of fixes against filters that have not used them, where a detector reads it.
    """

    tested: Flags = blank(False)
    along: Floats = blank(0.0)
    across: Floats = blank(0.0)
    camera: Floats = blank(0.0)
    blind: Flags = blank(False)
    fix_age_s: Floats = blank(0.0)
    joint: Floats = blank(0.0)
    innovation: Floats = blank(0.0)
    separation: Floats = blank(0.0)


def first_channels(table: Table[Channels], count: int) -> Channels:
    """Return the first `count` rows of a table, which grows where it is too short."""
    table.grow(count)
    return Channels._make(array[:count] for array in table.now)


def silent_channels(shape: tuple[int, ...]) -> Channels:
    """Return what is said where the monitor does not run."""
    return Channels._make(np.zeros(shape, array.dtype) for array in Table(Channels).now)
