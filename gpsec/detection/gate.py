"""The gate of the monitor: fixes whose statistic is above it are kept out.

It is the threshold that `joint` has at 0.1 false alarms an hour, for a profile and association. A gate below the
threshold of a detector would leak: the monitor would refuse fixes, and later take the vehicle back, without an alarm.
So gate and threshold are one number, and it is looked for as one. Until its first alarm a vehicle does as with a
monitor that has no gate, so that only those are looked at again that reach a gate there.
"""

from collections.abc import Mapping
from math import inf

import numpy as np

from gpsec.core.threads import Threads
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES, Calibrated, Rate, ReplayCounts, Search, replay
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


def search_gate(
    opened: Grid, counts: ReplayCounts, rate: Rate, settle_s: float, threads: Threads | None = None
) -> Calibrated | None:
    """Search for the gate at which `joint`, with it as its threshold, has a rate, None where there is too little data.

    Args:
        opened: benign vehicles, with what a monitor without a gate says.
        counts: of `joint` on them, or on vehicles of which these are all that came near.
        rate: that is wanted.
        settle_s: samples before that age of a vehicle are seen but do not count.
        threads: for the kernels.
    """
    wanted = counts.expected(rate)
    values = np.unique(counts.settled_peak if rate.per_hour else counts.statistic)
    if wanted < MIN_EVENTS or not len(values):
        return None
    search = Search(rate, values, max(len(values) - 1 - round(wanted), 0))
    for _ in range(MAX_ROUNDS):
        near = monitored(opened.select(counts.peak > search.trial), search.trial, threads, looks_back=False)
        search.learn(replay(Joint(), near, search.trial, settle_s, threads).rate(rate, counts))
        if search.finished:
            break
    return search.best


def with_gate(grid: Grid, settle_s: float, threads: Threads | None = None) -> tuple[Grid, dict[str, Calibrated | None]]:
    """Find the gate on benign vehicles.

    Returns:
        The vehicles with what the monitor says with the gate, and the gate by its rate; without one, where there is too
        little data for any rate, the gate is open.
    """
    opened = monitored(grid, inf, threads, looks_back=False)
    counts = replay(Joint(), opened, inf, settle_s, threads)
    for name in _RATES:
        gate = search_gate(opened, counts, RATES[name], settle_s, threads)
        if gate is not None:
            return monitored(grid, gate.threshold, threads), {name: gate}
    return monitored(grid, inf, threads), {}
