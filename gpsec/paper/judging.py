"""`gpsec judge`: scores of a dataset become alarms, and the rows that `detection.csv` has of gpsec's own detectors.

A score goes through the steps as the statistic of a detector does in a run: over the threshold is an alarm, which is
held where nothing is scored; the track of an attack begins with all that its benign track had. Thresholds are those at
which the vehicles of the split `calibration` have the rate of false alarms that is asked for.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints, Longs
from gpsec.core.errors import GpsecError
from gpsec.core.progress import DONE, Progress, Report
from gpsec.core.tables import Table
from gpsec.detection.alarm import steps_in
from gpsec.detection.calibration import RATES
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.accumulate import add_step
from gpsec.outcomes.aggregates import StatisticCounts, detection_table
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.histograms import BINS, count, lowest_threshold
from gpsec.outcomes.state import LIFE, OutcomeState
from gpsec.outcomes.study import Study
from gpsec.paper.dataset import STATED
from gpsec.paper.scored import ScoredRun, read_scored
from gpsec.types.answers import Answers
from gpsec.types.points import HOLD_S, point_name
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity, Vehicles

JUDGED_TABLE = "judged.csv"
JUDGED_RATES = ("1e-3/sample", "1/h", "0.1/h")
# What a dataset does not tell: lines are not in it.
_UNKNOWN = ("n_line_events", "seen_before_line_share", "seen_before_line_share_lo", "seen_before_line_share_hi")


@dataclass(frozen=True)
class ReplayedScores:
    """What was counted of a run.

    Attributes:
        tracks: ordered by vehicle and plan.
        counts: of the statistics.
    """

    tracks: ClosedTracks
    counts: StatisticCounts


def profile_of(dataset: Path) -> str:
    """Return the sensor profile of a dataset.

    Raises:
        GpsecError: it is none.
    """
    path = dataset / STATED
    try:
        return str(json.loads(path.read_text("utf-8"))["profile"])
    except (OSError, ValueError, LookupError, TypeError):
        raise GpsecError(f"{path}: expected what gpsec dataset has written, found something else or nothing") from None


def splits_of(dataset: Path) -> dict[str, list[Path]]:
    """Return the files of the splits that are judged.

    Raises:
        GpsecError: there are none.
    """
    files = {split: sorted((dataset / split).glob("*.parquet")) for split in ("calibration", "test")}
    for split, found in files.items():
        if not found:
            raise GpsecError(f"{dataset / split}: expected files of a dataset, found none")
    return files


def judge_scores(
    files: Mapping[str, Sequence[Path]], scores: Path, name: str, profile: str, report: Report
) -> pd.DataFrame:
    """Return a row for each test file, attack and rate, with the columns of `detection.csv`.

    Args:
        files: of the dataset, by split.
        scores: a folder with a file of the same name for each of these, in folders of the same names.
        name: of the detector.
        profile: of the vehicles.
        report: of each file that is done.

    Raises:
        GpsecError: a file is missing or wrong, or the calibration is too short for any rate.
    """
    benign = []
    for path in files["calibration"]:
        run = read_scored(path, scores / "calibration" / path.name)
        benign.append((replay(run, np.full(1, np.inf)), run.step_s))
        report(Progress(f"calibration/{path.stem}", stage=DONE))
    thresholds = thresholds_of(benign)
    if not thresholds:
        raise GpsecError(f"{scores / 'calibration'}: too few scores for a threshold at {' or '.join(JUDGED_RATES)}")
    tables = []
    for path in files["test"]:
        run = read_scored(path, scores / "test" / path.name)
        study = study_of(run, name, profile, thresholds)
        found = replay(run, study.thresholds[0])
        tables.append(detection_table(study, found.tracks, found.counts, path.stem, Bootstrap(1)))
        report(Progress(f"test/{path.stem}", stage=DONE))
    return pd.concat(tables, ignore_index=True).drop(columns=list(_UNKNOWN))


def thresholds_of(benign: Sequence[tuple[ReplayedScores, float]]) -> dict[str, float]:
    """Return the threshold of each rate that the benign runs can tell, of replays and the length of their steps."""
    histogram = sum(found.counts.histogram[0, 0, 0, 0] for found, _ in benign)
    rises = sum(found.counts.rises[0, 0] for found, _ in benign)
    hours = sum(found.tracks.state.steps[:, LIFE].sum() * step_s / 3600.0 for found, step_s in benign)
    samples, alarms = (np.cumsum(each[::-1])[::-1] for each in (histogram, rises))
    told = {}
    for rate in JUDGED_RATES:
        asked = RATES[rate]
        above, allowed = (alarms, asked.value * hours) if asked.per_hour else (samples, asked.value * samples[0])
        threshold = lowest_threshold(above, allowed)
        if threshold is not None:
            told[rate] = threshold
    return told


def study_of(run: ScoredRun, name: str, profile: str, thresholds: Mapping[str, float]) -> Study:
    """Return the study of a run whose detector has these thresholds, by rate."""
    points = tuple(point_name(name, rate) for rate in thresholds)
    limits = np.array([list(thresholds.values())])
    origins = ("counted",) * len(points)
    return Study(run.plans, points, tuple(thresholds), origins, (("never", "none"),), (profile,), limits, run.step_s)


def replay(run: ScoredRun, thresholds: Floats) -> ReplayedScores:
    """Let the scores of a run go through its steps at K thresholds."""
    vehicles, plans, points = len(run.vehicles), len(run.plans), len(thresholds)
    tracks = Table(Tracks, len(run.plan)).now
    tracks.vehicle[:], tracks.plan[:] = run.vehicle, run.plan
    answers = Table(Answers, len(run.plan), detectors=points, defences=1)
    sums = Table(OutcomeState, len(run.plan), detectors=points, defences=1)
    histogram = np.zeros((plans, 1, points, 2, BINS), np.int64)
    rises = np.zeros((1, points, BINS), np.int64)
    replayed = _Replay(run, tracks, answers, sums, Table(Vehicles, vehicles).now, thresholds)
    edges = np.flatnonzero(np.diff(run.step, prepend=run.step[0] - 1, append=run.step[-1] + 1))
    for first, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        replayed.step(slice(first, end), histogram, rises)
    people = [Identity(run.vehicles[v], "", 0, 0.0, run.vehicles[v]) for v in run.vehicle.tolist()]
    every = np.arange(len(run.plan), dtype=np.int32)
    closed = ClosedTracks.at(every, tracks, sums.now, people, None)
    return ReplayedScores(ClosedTracks.concatenate([closed]), StatisticCounts(histogram, rises))


class _Replay:
    """The tracks of a run, step by step."""

    def __init__(
        self,
        run: ScoredRun,
        tracks: Tracks,
        answers: Table[Answers],
        sums: Table[OutcomeState],
        vehicles: Vehicles,
        thresholds: Floats,
    ) -> None:
        self._run, self._tracks, self._answers, self._sums = run, tracks, answers, sums
        self._vehicles, self._thresholds = vehicles, thresholds
        self._hold_steps = steps_in(HOLD_S, run.step_s)
        self._benign = np.full(len(run.vehicles), -1, np.int32)
        of_none = np.flatnonzero(run.plan == 0).astype(np.int32)
        self._benign[run.vehicle[of_none]] = of_none
        sums.now.twin[:] = self._benign[run.vehicle]
        self._sides = LaneSides(
            *(np.zeros(1, np.bool_ if name == "internal" else np.float64) for name in LaneSides._fields)
        )

    def step(self, part: slice, histogram: Longs, rises: Longs) -> None:
        run, tracks, answers, sums = self._run, self._tracks, self._answers.now, self._sums.now
        rows, step = run.track[part], int(run.step[part.start])
        attacked = run.attacked[part]
        begun = rows[attacked & (tracks.start_step[rows] < 0)]
        if len(begun):
            self._fork(begun, step)
        over = rows[~attacked & tracks.attacked[rows] & (tracks.end_step[rows] < 0)]
        tracks.end_step[over] = step
        tracks.settled[rows], tracks.attacked[rows] = run.settled[part], attacked
        self._answer(rows, run.score[part])
        rows = np.sort(rows)
        listens = np.zeros(1, np.int32)
        add_step(rows, step, tracks, self._vehicles, answers, sums, self._sides, listens)
        count(rows, tracks, self._vehicles, sums, answers.unscored_steps, self._hold_steps, histogram, rises)

    def _fork(self, begun: Ints, step: int) -> None:
        source = self._benign[self._tracks.vehicle[begun]]
        known = source >= 0
        for table in (self._answers, self._sums):
            table.copy(source[known], begun[known])
        self._sums.now.twin[begun] = source
        self._tracks.start_step[begun] = step

    def _answer(self, rows: Ints, score: Floats) -> None:
        answers, scored = self._answers.now, ~np.isnan(score)
        some, none = rows[scored], rows[~scored]
        answers.scored[rows] = scored[:, None]
        answers.statistic[rows] = np.where(scored, score, 0.0)[:, None]
        answers.alarm[some] = score[scored, None] > self._thresholds
        answers.unscored_steps[some] = 0
        answers.unscored_steps[none] += 1
        answers.alarm[none] &= answers.unscored_steps[none] <= self._hold_steps
