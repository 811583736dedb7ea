"""Isolation forest on windows of the residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.core.arrays import Floats, Floats32, Ints
from gpsec.core.kernels import allocating_kernel, inline
from gpsec.detection.alarm import Alarms, AlarmState, blank_alarm, decide, gap_before, hold
from gpsec.detection.base import KernelDetector, Observation
from gpsec.detection.blocks import choose
from gpsec.detection.forest import BLOCK, WIDTH, Forest, Walkers, join, walk
from gpsec.detection.learned import Learned
from gpsec.detection.ring import push

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


@inline
def describe(window: Floats, count: Ints, row: int, features: Floats32, n: int) -> None:
    """Fill in the features of the full ring of `row`: `features[n]`."""
    total = 0.0
    for j in range(WINDOW):
        # From the oldest to the newest, so that the sum does not depend on where the ring begins.
        total += window[row, (count[row] + j) % WINDOW]
    side = -1.0 if total < 0.0 else 1.0
    for j in range(WINDOW):
        features[n, j] = min(max(side * window[row, (count[row] + j) % WINDOW], -_LIMIT), _LIMIT)
    features[n, WINDOW] = min(side * total / WINDOW, _LIMIT)


@allocating_kernel
def _update(
    part: Ints, seen: Observation, threshold: Floats, alarms: Alarms, forest: Forest, window: Floats, count: Ints
) -> None:
    full = np.empty(BLOCK, np.bool_)
    chosen = np.empty(BLOCK, np.int32)
    walkers = Walkers(np.empty((BLOCK, WIDTH), np.float32), np.empty(BLOCK, np.uint32), np.empty(BLOCK))
    for start in range(0, len(part), BLOCK):
        block = part[start : start + BLOCK]
        for n in range(len(block)):
            i = block[n]
            row = seen.rows[i]
            full[n] = False
            if seen.valid[i]:
                if gap_before(alarms, row):
                    count[row] = 0
                full[n] = push(window, count, row, seen.residual_m[i] / seen.scale_m[i])
            else:
                alarms.since_valid[row] += 1
            if not full[n]:
                hold(alarms, row)
        for profile in range(len(forest.scale)):
            ready = choose(chosen, block, full, seen.profile, profile)
            for n in range(ready):
                describe(window, count, seen.rows[chosen[n]], walkers.features, n)
            walk(forest, profile, walkers, ready)
            for n in range(ready):
                i = chosen[n]
                decide(alarms, seen.rows[i], walkers.score[n], threshold[i])


@dataclass(frozen=True)
class IsolationForest(KernelDetector):
    """How few random cuts isolate a window of residuals from benign ones (Liu, Ting and Zhou, ICDM 2008).

    The features are the last w normalised residuals, oldest first, and their mean, all with the sign that makes the
    mean positive: both signs of a residual are alike. Spread and jumps are none, since a constant bias has none.

    Attributes:
        learned: the arrays of each profile's forest.
    """

    name: ClassVar[str] = "isolation_forest"
    kernel = _update
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

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("IsolationForestState", state)
        return self.forest, own.window, own.count
