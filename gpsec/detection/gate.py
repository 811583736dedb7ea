"""The gate of the monitor: fixes whose statistic is above it are kept out.

It is the threshold that `joint` has at 0.1 false alarms an hour, for a profile and association. A gate below the
threshold of a detector would leak: the monitor would refuse fixes, and later take the vehicle back, without an alarm.
The gate is found with a monitor that has none: so many benign vehicles reach it there as alarms are to begin. Until its
first alarm a vehicle does the same in both, so that they are the same behind the gate, and there is nothing to iterate.
"""

from collections.abc import Mapping
from math import inf

import numpy as np

from gpsec.core.threads import Threads
from gpsec.detection.calibration import MIN_EVENTS, RATES, Calibrated, ReplayCounts, at_threshold, replay
from gpsec.detection.joint import Joint
from gpsec.detection.logs import Grid
from gpsec.detection.monitored import monitored

# The detector whose threshold the gate is.
GATED_BY = Joint.name
# Its rate, and those that it is of where there is too little benign data for that, the strictest first.
GATED_AT = "0.1/h"
_RATES = (GATED_AT, "1/h", "1e-4/sample", "1e-3/sample")

# rate -> detector -> threshold, None where there was too little data
Thresholds = Mapping[str, Mapping[str, Calibrated | None]]


def gate_of(thresholds: Thresholds) -> float | None:
    """Return the gate that goes with thresholds, None where they have none of `joint`."""
    found = (thresholds.get(rate, {}).get(GATED_BY) for rate in _RATES)
    return next((one.threshold for one in found if one is not None), None)


def gate_from(opened: ReplayCounts) -> float | None:
    """Return the gate that benign vehicles ask for behind an open one, None where there are too few for any rate."""
    for name in _RATES:
        rate = RATES[name]
        if opened.expected(rate) >= MIN_EVENTS:
            values = np.sort(opened.settled_peak if rate.per_hour else opened.statistic)
            return float(values[-1 - round(opened.expected(rate))])
    return None


def with_gate(grid: Grid, settle_s: float, threads: Threads | None = None) -> tuple[Grid, float]:
    """Find the gate on benign vehicles; return these with what the monitor says with it, and the gate.

    It is infinite where there is too little data for any rate.
    """
    opened = replay(Joint(), monitored(grid, inf, threads, looks_back=False), inf, settle_s, threads)
    gate = gate_from(opened)
    gate = inf if gate is None else gate
    return monitored(grid, gate, threads), gate


def at_gate(
    found: dict[str, Calibrated | None], grid: Grid, gate: float, settle_s: float, threads: Threads | None = None
) -> dict[str, Calibrated | None]:
    """Return thresholds of `joint` by rate, of which the strictest is the gate, with the rate that it has with it."""
    strictest = next((rate for rate in _RATES if found.get(rate) is not None), None)
    if strictest is None:
        return found
    return {**found, strictest: at_threshold(Joint(), grid, RATES[strictest], gate, settle_s, threads)}
