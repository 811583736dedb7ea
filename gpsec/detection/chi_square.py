"""Chi-square test of the residual."""

from dataclasses import dataclass
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.detection.alarm import (
    GAP_S,
    HOLD_S,
    AlarmState,
    blank_alarm,
    decide,
    gap_before,
    hold,
    run_on,
    steps_in,
)
from gpsec.detection.base import Detector, Observation, Verdict
from gpsec.detection.ring import mean, push
from gpsec.fleet import Rows
from gpsec.kernels import kernel
from gpsec.threads import Threads


@dataclass
class ChiSquareState(AlarmState):
    """Attributes beside those of `AlarmState`.

    square: (M, n) ring of the last squared normalised residuals.
    count: (M,) how many of them have been seen.
    """

    square: Floats
    count: Ints

    @classmethod
    def empty(cls, capacity: int, window: int = 1) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(
            **blank_alarm(capacity),
            square=np.zeros((capacity, window)),
            count=np.zeros(capacity, np.int32),
        )


@dataclass(frozen=True)
class ChiSquare(Detector):
    """Mean of the last n squared residuals in units of what the sensor profile promises.

    q = (1/n)·Σ (z/scale)²: n·q has a chi-square distribution with n degrees of freedom when the residual is white.

    Attributes:
        window: n; scoring begins with the n-th sample.
    """

    name: ClassVar[str] = "chi_square"
    window: int = 3

    def new_state(self, capacity: int) -> ChiSquareState:
        """Return the detector's arrays for `capacity` rows."""
        return ChiSquareState.empty(capacity, self.window)

    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Take one step."""
        own = cast("ChiSquareState", state)
        verdict = Verdict.blank(len(observation.rows))
        run_on(threads).run(
            _update,
            np.arange(len(observation.rows), dtype=np.int32),
            observation.rows,
            observation.residual_m,
            observation.valid,
            observation.scale_m,
            threshold,
            steps_in(GAP_S, observation.step_s),
            steps_in(HOLD_S, observation.step_s),
            own.square,
            own.count,
            own.alarm,
            own.since_valid,
            own.since_scored,
            verdict.statistic,
            verdict.scored,
            verdict.alarm,
        )
        return verdict


@kernel
def _update(
    part: Ints,
    rows: Ints,
    residual_m: Floats,
    valid: Flags,
    scale_m: Floats,
    threshold: Floats,
    gap_steps: int,
    hold_steps: int,
    square: Floats,
    count: Ints,
    alarm: Flags,
    since_valid: Ints,
    since_scored: Ints,
    statistic: Floats,
    scored: Flags,
    alarms: Flags,
) -> None:
    for i in part:
        row = rows[i]
        full = False
        if valid[i]:
            if gap_before(since_valid, row, gap_steps):
                count[row] = 0
            z = residual_m[i] / scale_m[i]
            full = push(square, count, row, z * z)
        else:
            since_valid[row] += 1
        if full:
            decide(i, row, mean(square, row), threshold[i], alarm, since_scored, statistic, scored, alarms)
        else:
            hold(i, row, hold_steps, alarm, since_scored, statistic, scored, alarms)
