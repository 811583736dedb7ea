"""What the detectors and the defences of a run say."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats
from gpsec.core.tables import blank


class Answers(NamedTuple):
    """What K detectors and D defences say of M tracks after a step.

    Attributes:
        statistic, scored, alarm: (M, K) of the detectors.
        estimate_m: (M, D, 2) of the rear axle in the net's frame.
        isolated: (M, D) GNSS is not used.
    """

    statistic: Floats = blank(0.0, "detectors")
    scored: Flags = blank(False, "detectors")
    alarm: Flags = blank(False, "detectors")
    estimate_m: Floats = blank(0.0, "defences", 2)
    isolated: Flags = blank(False, "defences")
