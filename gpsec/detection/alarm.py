"""When an alarm begins, is held and ends; the same for every detector."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from gpsec.arrays import Flags, Ints
from gpsec.fleet import Rows
from gpsec.kernels import inline
from gpsec.threads import Threads

# Without a valid residual for longer than this, windows are emptied and warm-up begins again: behind a junction the
# road has another direction, and the GNSS error another lateral part.
GAP_S = 1.0
# Without a score for longer than this, an alarm ends. It outlasts most junctions, so that a vehicle that is being
# spoofed is not handed back to GNSS inside one; what a false alarm costs there is some seconds of dead reckoning.
HOLD_S = 5.0

_ALONE = Threads(1)


@dataclass
class AlarmState(Rows):
    """What every detector keeps for each of M rows; a detector adds its own fields in a subclass.

    Attributes:
        alarm: (M,) in alarm.
        since_valid: (M,) steps since the last valid residual.
        since_scored: (M,) steps since the last score.
    """

    alarm: Flags
    since_valid: Ints
    since_scored: Ints

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(*_blank_alarm(capacity))


def _blank_alarm(capacity: int) -> tuple[Flags, Ints, Ints]:
    return np.zeros(capacity, np.bool_), np.zeros(capacity, np.int32), np.zeros(capacity, np.int32)


def blank_alarm(capacity: int) -> dict[str, np.ndarray]:
    """Return the fields of `AlarmState` for `capacity` rows, for the constructor of a subclass."""
    alarm, since_valid, since_scored = _blank_alarm(capacity)
    return {"alarm": alarm, "since_valid": since_valid, "since_scored": since_scored}


def steps_in(duration_s: float, step_s: float) -> int:
    """Return how many whole steps fit into a duration."""
    return int(duration_s / step_s + 1e-9)


def run_on(threads: Threads | None) -> Threads:
    """Return `threads`, or the caller's own thread where there are none."""
    return _ALONE if threads is None else threads


@inline
def gap_before(since_valid: Ints, row: int, gap_steps: int) -> bool:
    """Count a valid residual at `row`: return whether the last one is too long ago."""
    gap = bool(since_valid[row] + 1 > gap_steps)
    since_valid[row] = 0
    return gap


@inline
def decide(
    i: int,
    row: int,
    value: float,
    threshold: float,
    alarm: Flags,
    since_scored: Ints,
    statistic: np.ndarray,
    scored: Flags,
    alarms: Flags,
) -> None:
    """Record a score for observation `i`: the alarm is on where it is over the threshold, and off where not."""
    statistic[i] = value
    scored[i] = True
    alarm[row] = value > threshold
    since_scored[row] = 0
    alarms[i] = alarm[row]


@inline
def hold(
    i: int,
    row: int,
    hold_steps: int,
    alarm: Flags,
    since_scored: Ints,
    statistic: np.ndarray,
    scored: Flags,
    alarms: Flags,
) -> None:
    """Record that observation `i` has no score: an alarm stays for `hold_steps`, then ends."""
    statistic[i] = 0.0
    scored[i] = False
    since_scored[row] += 1
    if since_scored[row] > hold_steps:
        alarm[row] = False
    alarms[i] = alarm[row]
