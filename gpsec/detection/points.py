"""A detector at several operating points: one statistic, and a threshold and an alarm for each false-alarm rate."""

from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, blank, taken
from gpsec.core.threads import Threads
from gpsec.detection.alarm import AlarmSteps
from gpsec.detection.base import Detector, Observation
from gpsec.types.answers import Answers


class Parted(NamedTuple):
    """Which of M rows have a state for each operating point.

    Attributes:
        parted: (M,) whether; while it is not so, the state of the first point is that of all.
    """

    parted: Flags = blank(False)


class Watch:
    """A detector with a column of the answers for each of its operating points.

    The answers are those of as many detectors that do not know of each other. A detector whose state does not depend
    on its alarm (`Detector.heeds_alarm`) scores once, and its statistic is compared with all thresholds. That of any
    other does not either until one of its points is in alarm. Then the row *parts*: from there on every point has a
    state of its own, begun from the one that all had before that step. Behind a gap in the residuals, which makes
    detectors forget, points whose states are the same again share one again.
    """

    def __init__(self, detector: Detector, columns: list[int]) -> None:
        """Watch with `detector`, whose operating points have the given `columns` of the answers."""
        self._detector = detector
        self._first, self._others = columns[0], columns[1:]
        shared = not self._others or not detector.heeds_alarm
        self._tables: list[Table[Any]] = [detector.new_state(1) for _ in (columns[:1] if shared else columns)]
        self._parted = Table(Parted)

    def states(self) -> list[Table[Any]]:
        """Return all that is remembered of rows."""
        return [self._parted, *self._tables]

    def update(self, seen: Observation, thresholds: Floats, answers: Answers, threads: Threads | None = None) -> None:
        """Take one step: score the residuals against (m, K) thresholds, of all columns of the answers."""
        if not self._others:
            self._score(0, seen, thresholds, answers, threads)
        elif len(self._tables) == 1:
            self._score(0, seen, thresholds, answers, threads)
            for column in self._others:
                self._compare(column, seen, thresholds[:, column], answers)
        else:
            self._score_parted(seen, thresholds, answers, threads)

    def _score(
        self, point: int, seen: Observation, thresholds: Floats, answers: Answers, threads: Threads | None
    ) -> None:
        column = [self._first, *self._others][point]
        threshold = np.ascontiguousarray(thresholds[:, column])
        self._detector.update(self._tables[point].now, seen, threshold, answers, column, threads)

    def _compare(self, column: int, seen: Observation, threshold: Floats, answers: Answers) -> None:
        """Answer in `column` with the statistic of the first point; the alarm is held as `alarm.hold` does."""
        rows = seen.rows
        statistic, scored = answers.statistic[rows, self._first], answers.scored[rows, self._first]
        unscored = answers.unscored_steps[rows, self._first]
        held = answers.alarm[rows, column] & (unscored <= AlarmSteps.at(seen.step_s).hold_steps)
        self._copy(rows, column, answers)
        answers.alarm[rows, column] = np.where(scored, statistic > threshold, held)

    def _copy(self, rows: Ints, column: int, answers: Answers) -> None:
        for array in (answers.statistic, answers.scored, answers.unscored_steps):
            array[rows, column] = array[rows, self._first]

    def _score_parted(self, seen: Observation, thresholds: Floats, answers: Answers, threads: Threads | None) -> None:
        parted = self._parted.now.parted
        before = parted[seen.rows]
        # What the second point goes on from, should the row part in this step.
        _carry_shared(self._tables[0], self._tables[1], seen.rows, parted)
        self._score(0, seen, thresholds, answers, threads)
        lowest = thresholds[:, [self._first, *self._others]].min(axis=1)
        parting = ~before & (answers.statistic[seen.rows, self._first] > lowest)
        for table in self._tables[2:]:
            _carry(self._tables[1], table, seen.rows[parting])
        apart = before | parting
        parted[seen.rows] = apart
        together = seen.rows[~apart]
        for column in self._others:
            self._copy(together, column, answers)
            answers.alarm[together, column] = False
        chosen = np.flatnonzero(apart).astype(np.int32)
        if len(chosen):
            some = _some(seen, chosen)
            for point in range(1, 1 + len(self._others)):
                self._score(point, some, thresholds[chosen], answers, threads)
            self._rejoin(some, answers)

    def _rejoin(self, seen: Observation, answers: Answers) -> None:
        """Let the points of a row share a state where all have forgotten what they differed in."""
        gap_steps = AlarmSteps.at(seen.step_s).gap_steps
        rows = seen.rows[seen.valid & (seen.elapsed_steps > gap_steps)]
        columns = [self._first, *self._others]
        rows = rows[~answers.alarm[rows[:, None], columns].any(axis=1)]
        if not len(rows):
            return
        same = np.ones(len(rows), np.bool_)
        for table in self._tables[1:]:
            for mine, theirs in zip(self._tables[0].arrays(), table.arrays(), strict=True):
                same &= (mine[rows] == theirs[rows]).reshape(len(rows), -1).all(axis=1)
        self._parted.now.parted[rows[same]] = False


def _carry_shared(source: Table[Any], target: Table[Any], rows: Ints, parted: Flags) -> None:
    """Copy all rows from the first to the last of `rows`, but for those that have (M,) parted.

    A row between them that is not looked at may be copied too: while it is shared, nobody reads the copy. One block is
    copied several times as fast as rows are picked.
    """
    if not len(rows):
        return
    block = slice(int(rows.min()), int(rows.max()) + 1)
    own = block.start + np.flatnonzero(parted[block])
    for mine, theirs in zip(source.arrays(), target.arrays(), strict=True):
        kept = theirs[own]
        theirs[block] = mine[block]
        theirs[own] = kept


def _carry(source: Table[Any], target: Table[Any], rows: Ints) -> None:
    """Copy rows of one table to the same rows of another one of the same structure."""
    if len(rows):
        for mine, theirs in zip(source.arrays(), target.arrays(), strict=True):
            theirs[rows] = mine[rows]


def _some(seen: Observation, chosen: Ints) -> Observation:
    """Return some of the rows of an observation."""
    arrays = (value[chosen] if isinstance(value, np.ndarray) else value for value in seen)
    return Observation._make(arrays)._replace(channels=taken(seen.channels, chosen))
