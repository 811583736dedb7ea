"""When an alarm begins, is held and ends; the same for every detector."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline
from gpsec.core.tables import Rows

# Without a valid residual for longer than this, windows are emptied and warm-up begins again: behind a junction the
# road has another direction, and the GNSS error another lateral part.
GAP_S = 1.0
# Without a score for longer than this, an alarm ends. It outlasts most junctions, so that a vehicle that is being
# spoofed is not handed back to GNSS inside one; what a false alarm costs there is some seconds of dead reckoning.
HOLD_S = 5.0


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
        return cls(**blank_alarm(capacity))


def blank_alarm(capacity: int) -> dict[str, np.ndarray]:
    """Return the fields of `AlarmState` for `capacity` rows, for the constructor of a subclass."""
    return {
        "alarm": np.zeros(capacity, np.bool_),
        "since_valid": np.zeros(capacity, np.int32),
        "since_scored": np.zeros(capacity, np.int32),
    }


class Alarms(NamedTuple):
    """What a kernel keeps alarms in, and where it answers.

    Attributes:
        alarm, since_valid, since_scored: (M,) as in `AlarmState`.
        statistic, scored, answer: (M, K) as in `Verdict`, `answer` being its alarm; only `column` is the kernel's own.
        column: see `Verdict`.
        gap_steps, hold_steps: `GAP_S` and `HOLD_S` in steps.
    """

    alarm: Flags
    since_valid: Ints
    since_scored: Ints
    statistic: Floats
    scored: Flags
    answer: Flags
    column: int
    gap_steps: int
    hold_steps: int


def steps_in(duration_s: float, step_s: float) -> int:
    """Return how many whole steps fit into a duration."""
    return int(duration_s / step_s + 1e-9)


@inline
def gap_before(alarms: Alarms, row: int) -> bool:
    """Count a valid residual at `row`: return whether the last one is too long ago."""
    gap = bool(alarms.since_valid[row] + 1 > alarms.gap_steps)
    alarms.since_valid[row] = 0
    return gap


@inline
def decide(alarms: Alarms, row: int, value: float, threshold: float) -> None:
    """Record a score for `row`: the alarm is on where it is over the threshold, and off where not."""
    alarms.statistic[row, alarms.column] = value
    alarms.scored[row, alarms.column] = True
    alarms.alarm[row] = value > threshold
    alarms.since_scored[row] = 0
    alarms.answer[row, alarms.column] = alarms.alarm[row]


@inline
def hold(alarms: Alarms, row: int) -> None:
    """Record that `row` has no score: an alarm stays for `hold_steps`, then ends."""
    alarms.statistic[row, alarms.column] = 0.0
    alarms.scored[row, alarms.column] = False
    alarms.since_scored[row] += 1
    if alarms.since_scored[row] > alarms.hold_steps:
        alarms.alarm[row] = False
    alarms.answer[row, alarms.column] = alarms.alarm[row]
