"""Detectors whose formula is compiled: the loop over rows is written here, once for each family.

A detector gives the functions, each of one row:

- ``forget(state, row, alarm)`` begins anew, where the last valid residual is longer than `GAP_S` ago; an `alarm` may
  still be held.
- ``score(state, seen, i, settings, alarm)`` returns the statistic for observation i, at least 0, or `NOT_YET`.
- ``remember(state, seen, i, settings, threshold, alarm)`` goes on once it is decided whether there is an alarm.

`state` is its structure of arrays at row ``seen.rows[i]``, and `settings` are its parameters. None of them is called
where the residual is not valid.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import allocating_kernel, always_inline, kernel
from gpsec.core.threads import Threads
from gpsec.detection.alarm import AlarmSteps, decide, hold
from gpsec.detection.base import Detector, Observation
from gpsec.types.answers import Answers

# What `score` returns while a window is not full.
NOT_YET = -1.0
_ALONE = Threads(1)


class KernelDetector(Detector):
    """A detector whose formula is a kernel.

    Attributes:
        kernel: made by `each_residual`, `each_tested` or `each_block`; it updates the rows of an observation at some
            positions.
    """

    kernel: ClassVar[Callable[..., None]]

    @property
    def settings(self) -> tuple[Any, ...]:
        """The parameters as the functions of the kernel read them: a structure of numbers and arrays, or nothing."""
        return ()

    def update(
        self,
        state: Any,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        threads: Threads | None = None,
    ) -> None:
        """Hand the observation to the kernel."""
        positions = np.arange(len(seen.rows), dtype=np.int32)
        run = (_ALONE if threads is None else threads).run
        alarm_steps = AlarmSteps.at(seen.step_s)
        run(self.kernel, positions, seen, threshold, answers, column, alarm_steps, state, self.settings)


@always_inline
def nothing(state: Any, seen: Observation, i: int, settings: Any, threshold: float, alarm: bool) -> None:
    """Remember nothing."""


@cache
def each_residual(
    forget: Callable[..., None], score: Callable[..., float], remember: Callable[..., None] = nothing
) -> Callable[..., None]:
    """Return the kernel of a detector that takes one residual after another."""

    @kernel
    def update(
        part: Ints,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        alarm_steps: AlarmSteps,
        state: Any,
        settings: Any,
    ) -> None:
        for i in part:
            row = seen.rows[i]
            statistic = NOT_YET
            if seen.valid[i]:
                if seen.elapsed_steps[i] > alarm_steps.gap_steps:
                    forget(state, row, answers.alarm[row, column])
                statistic = score(state, seen, i, settings, answers.alarm[row, column])
            if statistic >= 0.0:
                alarm = decide(answers, row, column, statistic, threshold[i])
            else:
                alarm = hold(answers, row, column, alarm_steps.hold_steps)
            if seen.valid[i]:
                remember(state, seen, i, settings, threshold[i], alarm)

    return update


@cache
def each_tested(statistic: Callable[[Observation, int], float]) -> Callable[..., None]:
    """Return the kernel of a detector whose ``statistic(seen, i)`` is the monitor's, wherever that has tested a fix."""

    @kernel
    def update(
        part: Ints,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        alarm_steps: AlarmSteps,
        state: Any,
        settings: Any,
    ) -> None:
        for i in part:
            row = seen.rows[i]
            if seen.channels.tested[i]:
                decide(answers, row, column, statistic(seen, i), threshold[i])
            else:
                hold(answers, row, column, alarm_steps.hold_steps)

    return update


@cache
def each_block(
    size: int,
    workspace: Callable[[], Any],
    evaluate: Callable[..., None],
    forget: Callable[..., None],
    score: Callable[..., float],
    remember: Callable[..., None],
) -> Callable[..., None]:
    """Return the kernel of a detector with a model that is faster where it takes rows together.

    Args:
        size: how many it takes.
        workspace: returns the arrays that it works in.
        evaluate: ``evaluate(chosen, count, state, seen, settings, profile, work)`` asks the model of a profile for the
            first `count` of the chosen observations, and leaves what it says in the workspace.
        forget: see above.
        score: is told the workspace, too, and the place n of the observation in it.
        remember: likewise.
    """

    @allocating_kernel
    def update(
        part: Ints,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        alarm_steps: AlarmSteps,
        state: Any,
        settings: Any,
    ) -> None:
        work = workspace()
        chosen = np.empty(size, np.int32)
        for start in range(0, len(part), size):
            block = part[start : start + size]
            profiles = 0
            for i in block:
                row = seen.rows[i]
                if not seen.valid[i]:
                    hold(answers, row, column, alarm_steps.hold_steps)
                    continue
                profiles = max(profiles, seen.profile[i] + 1)
                if seen.elapsed_steps[i] > alarm_steps.gap_steps:
                    forget(state, row, answers.alarm[row, column])
            for profile in range(profiles):
                count = 0
                for i in block:
                    if seen.valid[i] and seen.profile[i] == profile:
                        chosen[count] = i
                        count += 1
                evaluate(chosen, count, state, seen, settings, profile, work)
                for n in range(count):
                    i = chosen[n]
                    row = seen.rows[i]
                    statistic = score(state, seen, i, settings, answers.alarm[row, column], work, n)
                    if statistic >= 0.0:
                        alarm = decide(answers, row, column, statistic, threshold[i])
                    else:
                        alarm = hold(answers, row, column, alarm_steps.hold_steps)
                    remember(state, seen, i, settings, threshold[i], alarm, work, n)

    return update
