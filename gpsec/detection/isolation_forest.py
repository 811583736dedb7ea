"""Isolation forest on windows of the residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Floats, Floats32, Ints
from gpsec.core.kernels import allocating_kernel, always_inline, inline
from gpsec.core.tables import Table, blank
from gpsec.detection.base import Observation
from gpsec.detection.families import NOT_YET, KernelDetector, each_block
from gpsec.detection.forest import TREE_BLOCK, WIDTH, Forest, Walkers, join, walk
from gpsec.detection.learned import Learned
from gpsec.detection.ring import push

# Samples in a window, and the features made of it.
WINDOW = 4
FEATURES = (*(f"residual {age} samples ago" for age in reversed(range(WINDOW))), "mean")
# Far outside anything benign, all values are alike to a tree; float32 must hold them.
_LIMIT = 1e6


class IsolationForestState(NamedTuple):
    """M rows.

    Attributes:
        window: (M, w) ring of the last normalised residuals.
        counted: (M,) how many of them have been seen.
    """

    window: Floats = blank(0.0, WINDOW)
    counted: Ints = blank(0)


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
def _workspace() -> Walkers:
    return Walkers(np.empty((TREE_BLOCK, WIDTH), np.float32), np.empty(TREE_BLOCK, np.uint32), np.empty(TREE_BLOCK))


@always_inline
def _evaluate(
    chosen: Ints,
    count: int,
    state: IsolationForestState,
    seen: Observation,
    settings: Forest,
    profile: int,
    work: Walkers,
) -> None:
    for n in range(count):
        i = chosen[n]
        row = seen.rows[i]
        push(state.window, state.counted, row, seen.residual_m[i] / seen.scale_m[i])
        describe(state.window, state.counted, row, work.features, n)
    walk(settings, profile, work, count)


@always_inline
def _forget(state: IsolationForestState, row: int, alarm: bool) -> None:
    state.counted[row] = 0


@always_inline
def _score(
    state: IsolationForestState, seen: Observation, i: int, settings: Forest, alarm: bool, work: Walkers, n: int
) -> float:
    return work.score[n] if state.counted[seen.rows[i]] >= WINDOW else NOT_YET


@always_inline
def _remember(
    state: IsolationForestState,
    seen: Observation,
    i: int,
    settings: Forest,
    threshold: float,
    alarm: bool,
    work: Walkers,
    n: int,
) -> None:
    """Remember nothing more than the window."""


@dataclass(frozen=True)
class IsolationForest(KernelDetector):
    """How few random cuts isolate a window of residuals from benign ones (Liu, Ting and Zhou, ICDM 2008).

    The features are the last w normalised residuals, oldest first, and their mean, all with the sign that makes the
    mean positive: both signs of a residual are alike. Spread and jumps are none, since a constant bias has none.

    Attributes:
        learned: the arrays of each profile's forest.
    """

    name: ClassVar[str] = "isolation_forest"
    heeds_alarm: ClassVar[bool] = False
    kernel = each_block(TREE_BLOCK, _workspace, _evaluate, _forget, _score, _remember)
    learned: tuple[Learned, ...]

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        detector = cls(tuple(learned))
        _ = detector.settings
        return detector

    @cached_property
    def settings(self) -> Forest:
        """The forests of all profiles as flat arrays."""
        return join(self.learned, len(FEATURES))

    def new_state(self, capacity: int) -> Table[IsolationForestState]:
        """Return empty windows for `capacity` rows."""
        return Table(IsolationForestState, capacity)
