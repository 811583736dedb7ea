"""Isolation forest on windows of the residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.arrays import Flags, Floats, Floats32, Ints
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
from gpsec.detection.forest import Forest, join, score_one
from gpsec.detection.learned import Learned
from gpsec.detection.ring import push
from gpsec.fleet import Rows
from gpsec.kernels import allocating_kernel, inline
from gpsec.threads import Threads

# Samples in a window, and the features made of it.
WINDOW = 4
FEATURES = (*(f"residual {age} samples ago" for age in reversed(range(WINDOW))), "mean")
# Far outside anything benign, all values are alike to a tree; float32 must hold them.
_LIMIT = 1e6


@dataclass
class IsolationForestState(AlarmState):
    """Attributes beside those of `AlarmState`.

    window: (M, w) ring of the last normalised residuals.
    count: (M,) how many of them have been seen.
    """

    window: Floats
    count: Ints

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(
            **blank_alarm(capacity),
            window=np.zeros((capacity, WINDOW)),
            count=np.zeros(capacity, np.int32),
        )


@dataclass(frozen=True)
class IsolationForest(Detector):
    """How few random cuts isolate a window of residuals from benign ones (Liu, Ting and Zhou, ICDM 2008).

    The features are the last w normalised residuals, oldest first, and their mean, all with the sign that makes the
    mean positive: both signs of a residual are alike. Spread and jumps are none, since a constant bias has none.

    Attributes:
        learned: the arrays of each profile's forest.
    """

    name: ClassVar[str] = "isolation_forest"
    learned: tuple[Learned, ...]

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        detector = cls(tuple(learned))
        _ = detector.forest
        return detector

    @cached_property
    def forest(self) -> Forest:
        """The forests of all profiles as flat arrays."""
        return join(self.learned, len(FEATURES))

    def new_state(self, capacity: int) -> IsolationForestState:
        """Return the detector's arrays for `capacity` rows."""
        return IsolationForestState.empty(capacity)

    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Take one step."""
        own = cast("IsolationForestState", state)
        verdict = Verdict.blank(len(observation.rows))
        run_on(threads).run(
            _update,
            np.arange(len(observation.rows), dtype=np.int32),
            observation.rows,
            observation.profile,
            observation.residual_m,
            observation.valid,
            observation.scale_m,
            threshold,
            steps_in(GAP_S, observation.step_s),
            steps_in(HOLD_S, observation.step_s),
            self.forest,
            own.window,
            own.count,
            own.alarm,
            own.since_valid,
            own.since_scored,
            verdict.statistic,
            verdict.scored,
            verdict.alarm,
        )
        return verdict


@inline
def describe(window: Floats, count: Ints, row: int, features: Floats32) -> None:
    """Fill in the (F,) features of the full ring of `row`."""
    total = 0.0
    for j in range(WINDOW):
        # From the oldest to the newest, so that the sum does not depend on where the ring begins.
        total += window[row, (count[row] + j) % WINDOW]
    side = -1.0 if total < 0.0 else 1.0
    for j in range(WINDOW):
        features[j] = min(max(side * window[row, (count[row] + j) % WINDOW], -_LIMIT), _LIMIT)
    features[WINDOW] = min(side * total / WINDOW, _LIMIT)


@allocating_kernel
def _update(
    part: Ints,
    rows: Ints,
    profile: Ints,
    residual_m: Floats,
    valid: Flags,
    scale_m: Floats,
    threshold: Floats,
    gap_steps: int,
    hold_steps: int,
    forest: Forest,
    window: Floats,
    count: Ints,
    alarm: Flags,
    since_valid: Ints,
    since_scored: Ints,
    statistic: Floats,
    scored: Flags,
    alarms: Flags,
) -> None:
    features = np.empty(len(FEATURES), np.float32)
    for i in part:
        row = rows[i]
        full = False
        if valid[i]:
            if gap_before(since_valid, row, gap_steps):
                count[row] = 0
            full = push(window, count, row, residual_m[i] / scale_m[i])
        else:
            since_valid[row] += 1
        if full:
            describe(window, count, row, features)
            value = score_one(forest, profile[i], features)
            decide(i, row, value, threshold[i], alarm, since_scored, statistic, scored, alarms)
        else:
            hold(i, row, hold_steps, alarm, since_scored, statistic, scored, alarms)
