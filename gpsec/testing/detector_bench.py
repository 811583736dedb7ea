"""A detector at work, to be checked: it, what it remembers and what it answers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, taken
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector, Observation
from gpsec.detection.logs import Grid
from gpsec.testing.contract import require
from gpsec.testing.watched import watched
from gpsec.types.answers import Answers

CASE_PROFILES = ("first", "second")


class Answer(NamedTuple):
    """(m,) or (T, m) statistic, scored and alarm."""

    statistic: Floats
    scored: Flags
    alarm: Flags

    def bytes(self) -> tuple[bytes, ...]:
        """Return what two answers have in common that are equal to the last bit."""
        return tuple(np.ascontiguousarray(array).tobytes() for array in self)

    def at(self, part: Any) -> "Answer":
        """Return a part of every array."""
        return Answer(*(array[part] for array in self))


class Bench:
    """A detector at work on rows of its own; it has to answer in the second of three columns.

    Attributes:
        state: what it remembers.
    """

    def __init__(self, detector: Detector, capacity: int) -> None:
        self._detector = detector
        self.state = detector.new_state(capacity)
        self._answers = Table(Answers, capacity, detectors=3, defences=0)

    def ask(self, seen: Observation, threshold: Floats, threads: Threads | None = None) -> Answer:
        """Let the detector take a step, and return what it answers.

        Raises:
            BrokenContractError: it answered elsewhere.
        """
        answers = self._answers.now
        own = np.zeros(answers.alarm.shape, np.bool_)
        own[seen.rows, 1] = True
        columns: tuple[np.ndarray, ...] = answers.statistic, answers.scored, answers.alarm, answers.unscored_steps
        before = [array.copy() for array in columns]
        self._detector.update(self.state.now, seen, threshold, answers, 1, threads)
        pairs = zip(before, columns, strict=True)
        untouched = all(one[~own].tobytes() == other[~own].tobytes() for one, other in pairs)
        require(untouched, "answers stand at the observed rows of the detector's column, and nowhere else")
        at = seen.rows, 1
        return Answer(answers.statistic[at], answers.scored[at], answers.alarm[at])

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        self.state.reset(rows)
        self._answers.reset(rows)

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the rows `target` go on from where the rows `source` are."""
        self.state.copy(source, target)
        self._answers.copy(source, target)


@dataclass(frozen=True)
class DetectorCase:
    """A detector to be checked.

    Attributes:
        build: returns the detector for sensor profiles, of which there are one or two.
        threshold: that benign residuals of `gpsec.testing.residuals` seldom pass.
        slack: a bias of twice this multiple of the scale is more anomalous than none.
    """

    build: Callable[[Sequence[str]], Detector]
    threshold: float
    slack: float = 1.0

    def bench(self, capacity: int, profiles: Sequence[str] = CASE_PROFILES) -> Bench:
        """Return the detector at work on `capacity` rows."""
        return Bench(self.build(profiles), capacity)

    def watch(self, grid: Grid) -> Grid:
        """Return a grid with what the monitor says, if the detector reads it and the grid has it not."""
        reads = self.build(CASE_PROFILES[:1]).reads_monitor
        return watched(grid) if reads and grid.channels is None else grid

    def ask(self, bench: Bench, seen: Observation, threads: Threads | None = None) -> Answer:
        """Return what the detector answers with the threshold of the case."""
        return bench.ask(seen, np.full(len(seen.rows), self.threshold), threads)

    def run(
        self, grid: Grid, steps: int | None = None, bench: Bench | None = None, threads: Threads | None = None
    ) -> Answer:
        """Return (T, V) answers for all vehicles of a grid, whose profiles alternate."""
        grid = self.watch(grid)
        bench = self.bench(len(grid.length)) if bench is None else bench
        count = len(grid.valid) if steps is None else steps
        answers = [self.ask(bench, observe(grid, t), threads) for t in range(count)]
        return Answer(*(np.stack(column) for column in zip(*answers, strict=True)))


def observe(grid: Grid, t: int) -> Observation:
    """Return what there is to see in a step; the vehicles' profiles alternate."""
    seen = grid.observe(t)
    return seen._replace(profile=(seen.rows % 2).astype(np.int32))


def take(seen: Observation, chosen: Any) -> Observation:
    """Return some rows of an observation, in the order of `chosen`."""
    columns = (np.ascontiguousarray(column[chosen]) for column in seen[:-2])
    return Observation._make([*columns, taken(seen.channels, chosen), seen.step_s])
