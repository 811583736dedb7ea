"""What the detectors and the defences of a run say."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import blank


class Answers(NamedTuple):
    """What K detectors and D defences say of M tracks after a step.

    Attributes:
        statistic: (M, K) of the detectors; 0 where not scored.
        scored: (M, K) the statistic is defined in this step (a valid residual, and warm-up is over).
        alarm: (M, K) in alarm after this step; it is held where nothing was scored.
        unscored_steps: (M, K) steps since the last score.
        estimate_m: (M, D, 2) of the rear axle in the net's frame.
        isolated: (M, D) GNSS is not used.
    """

    statistic: Floats = blank(0.0, "detectors")
    scored: Flags = blank(False, "detectors")
    alarm: Flags = blank(False, "detectors")
    unscored_steps: Ints = blank(0, "detectors")
    estimate_m: Floats = blank(0.0, "defences", 2)
    isolated: Flags = blank(False, "defences")
