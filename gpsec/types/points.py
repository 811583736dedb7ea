"""Operating points: a detector at one false-alarm rate, and what it is called in tables."""

import re

_RATE = re.compile(r"@[^+_]+")
HEADLINE_RATE = "0.1/h"
"""The rate that one would drive with, and that a defence has where a scenario states none."""
HOLD_S = 5.0
"""For how long an alarm is held without a score.

It outlasts most junctions, so that a vehicle that is being spoofed is not handed back to GNSS inside one; what a false
alarm costs there is some seconds of dead reckoning.
"""
PER_SAMPLE = "1e-3/sample"
"""The rate at which detectors are compared with the paper's."""


def point_name(detector: str, rate: str) -> str:
    """Return the name of a detector at a false-alarm rate: at the headline rate its own, else ``detector@rate``."""
    return detector if rate == HEADLINE_RATE else f"{detector}@{rate}"


def without_rate(name: str) -> str:
    """Return the name of an operating point, of a defence or of a column of either without its rate."""
    return _RATE.sub("", name)


def detector_at(point: str) -> str:
    """Return the detector of an operating point or of a defence, by its name."""
    return point.partition("+")[0].partition("@")[0]
