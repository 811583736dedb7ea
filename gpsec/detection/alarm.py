"""When an alarm begins, is held and ends; the same for every detector."""

from typing import NamedTuple

from gpsec.core.kernels import inline
from gpsec.types.answers import Answers
from gpsec.types.points import HOLD_S

# Without a valid residual for longer than this, windows are emptied and warm-up begins again: behind a junction the
# road has another direction, and the GNSS error another lateral part.
GAP_S = 1.0


class AlarmSteps(NamedTuple):
    """`GAP_S` and `HOLD_S` in whole steps."""

    gap_steps: int
    hold_steps: int

    @classmethod
    def at(cls, step_s: float) -> "AlarmSteps":
        """Return those of a step length."""
        return cls(steps_in(GAP_S, step_s), steps_in(HOLD_S, step_s))


def steps_in(duration_s: float, step_s: float) -> int:
    """Return how many whole steps fit into a duration."""
    return int(duration_s / step_s + 1e-9)


@inline
def decide(answers: Answers, row: int, column: int, statistic: float, threshold: float) -> bool:
    """Answer with a statistic, and return whether it is an alarm: it is over the threshold."""
    answers.statistic[row, column] = statistic
    answers.scored[row, column] = True
    answers.alarm[row, column] = statistic > threshold
    answers.unscored_steps[row, column] = 0
    return bool(answers.alarm[row, column])


@inline
def hold(answers: Answers, row: int, column: int, hold_steps: int) -> bool:
    """Answer without a statistic, and return whether there is an alarm still: for `hold_steps`, then it ends."""
    answers.statistic[row, column] = 0.0
    answers.scored[row, column] = False
    answers.unscored_steps[row, column] += 1
    if answers.unscored_steps[row, column] > hold_steps:
        answers.alarm[row, column] = False
    return bool(answers.alarm[row, column])
