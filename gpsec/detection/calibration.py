"""Thresholds: every detector gets the same false-alarm rate, measured in the closed loop on benign runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gpsec.arrays import Flags, Floats
from gpsec.detection.base import Detector, Verdict
from gpsec.detection.learned import Progress, silent
from gpsec.detection.logs import Grid, ResidualLog
from gpsec.threads import Threads


@dataclass(frozen=True)
class Rate:
    """A false-alarm rate: alarmed samples per scored sample, or alarms that begin per vehicle-hour."""

    value: float
    per_hour: bool


RATES = {
    "1e-3/sample": Rate(1e-3, False),
    "1e-4/sample": Rate(1e-4, False),
    "1/h": Rate(1.0, True),
    "0.1/h": Rate(0.1, True),
}
# A rate is only calibrated where at least so many false alarms (or alarmed samples) are expected in the data.
MIN_EVENTS = 10.0
# The achieved rate may differ from the asked one by this share; few events allow no better.
TOLERANCE = 0.05
MAX_ROUNDS = 8


@dataclass(frozen=True)
class Calibrated:
    """A threshold and the false-alarm rate that it had on the calibration data."""

    threshold: float
    achieved: float


@dataclass(frozen=True)
class Replay:
    """What a detector did on a grid, C copies of V vehicles; only settled samples count.

    Attributes:
        scored, alarmed: (C,) samples that were scored, and those of them in alarm.
        onsets: (C,) alarms that began.
        hours: (C,) vehicle-hours.
        statistic: (s,) all scored values of the first copy.
    """

    scored: Floats
    alarmed: Floats
    onsets: Floats
    hours: Floats
    statistic: Floats

    def rate(self, copy: int, rate: Rate) -> float:
        """Return the achieved value of the same kind as `rate`."""
        if rate.per_hour:
            return float(self.onsets[copy] / self.hours[copy])
        return float(self.alarmed[copy] / self.scored[copy])

    def expected(self, rate: Rate) -> float:
        """Return how many events the data would hold at exactly that rate."""
        return float(rate.value * (self.hours[0] if rate.per_hour else self.scored[0]))


def replay(
    detector: Detector, grid: Grid, thresholds: Sequence[float], settle_s: float, threads: Threads | None = None
) -> Replay:
    """Run a detector over a grid exactly as in the loop, once for each of C thresholds."""
    copies, vehicles = len(thresholds), len(grid.length)
    state = detector.new_state(copies * vehicles)
    verdict = Verdict.blank(copies * vehicles)
    before: Flags = np.zeros(copies * vehicles, np.bool_)
    settle_steps = round(settle_s / grid.step_s)
    scored, alarmed, onsets, samples = (np.zeros(copies) for _ in range(4))
    values = []
    for step in range(len(grid.valid)):
        observation = grid.observe(step, copies)
        m = grid.active(step)
        detector.update(state, observation, np.repeat(np.asarray(thresholds, np.float64), m), verdict, threads)
        statistic, hit, alarm = verdict.at(observation.rows)
        if step >= settle_steps:
            samples += m
            by_copy = hit.reshape(copies, m), alarm.reshape(copies, m)
            scored += by_copy[0].sum(axis=1)
            alarmed += (by_copy[0] & by_copy[1]).sum(axis=1)
            onsets += (alarm & ~before[observation.rows]).reshape(copies, m).sum(axis=1)
            values.append(statistic[:m][hit[:m]])
        before[observation.rows] = alarm
    return Replay(scored, alarmed, onsets, samples * grid.step_s / 3600.0, np.concatenate([np.zeros(0), *values]))


def calibrate(
    detector: Detector,
    logs: Sequence[ResidualLog],
    settle_s: float = 10.0,
    progress: Progress = silent,
    threads: Threads | None = None,
) -> dict[str, Calibrated | None]:
    """Return the threshold for each of `RATES`, None where there is too little data to tell.

    The statistic of a detector may depend on its own alarm, so a threshold is not read off one distribution: it is the
    start of a bisection in which each round replays the closed loop with the thresholds of all rates side by side.

    Args:
        detector: built for the one profile of the logs.
        logs: benign runs of vehicles that the detector was not trained on.
        settle_s: samples before that age of a vehicle are seen by the detector but do not count.
        progress: told of every round.
        threads: for the kernels.
    """
    grid = Grid.of(logs)
    opened = replay(detector, grid, [np.inf], settle_s, threads)
    names = [name for name, rate in RATES.items() if opened.expected(rate) >= MIN_EVENTS]
    answer: dict[str, Calibrated | None] = dict.fromkeys(RATES)
    if not names:
        return answer
    searches = [_Search.start(RATES[name], opened) for name in names]
    for done in range(MAX_ROUNDS):
        progress(f"calibrating {detector.name}", done, MAX_ROUNDS)
        busy = [search for search in searches if not search.finished]
        if not busy:
            break
        found = replay(detector, grid, [search.trial for search in busy], settle_s, threads)
        for copy, search in enumerate(busy):
            search.learn(found.rate(copy, search.rate))
    progress(f"calibrating {detector.name}", MAX_ROUNDS, MAX_ROUNDS)
    for name, search in zip(names, searches, strict=True):
        answer[name] = search.best
    return answer


class _Search:
    """Bisection for the threshold of one rate, over the quantiles of the open-loop statistic."""

    def __init__(self, rate: Rate, values: Floats, start: int) -> None:
        self.rate = rate
        self._values = values  # sorted, without repetitions
        self._low, self._high = 0, len(values) - 1
        self._at = start
        self._step = 0
        self.best: Calibrated | None = None
        self.finished = False

    @classmethod
    def start(cls, rate: Rate, opened: Replay) -> "_Search":
        values = np.unique(opened.statistic)
        # An onset lasts for some samples; five is only a guess to begin with.
        share = 5.0 * opened.expected(rate) / opened.scored[0] if rate.per_hour else rate.value
        wanted = float(np.quantile(opened.statistic, max(0.0, 1.0 - share)))
        return cls(rate, values, int(np.searchsorted(values, wanted)))

    @property
    def trial(self) -> float:
        return float(self._values[self._at])

    def learn(self, achieved: float) -> None:
        """Take the rate that `trial` had, and choose the next one."""
        best = self.best
        if best is None or abs(achieved - self.rate.value) < abs(best.achieved - self.rate.value):
            self.best = Calibrated(self.trial, achieved)
        if abs(achieved - self.rate.value) <= TOLERANCE * self.rate.value:
            self.finished = True
            return
        # The number of values above a threshold is nearly proportional to the rate: that is the first guess; the
        # bracket keeps the search from running away.
        above = len(self._values) - self._at
        if achieved > self.rate.value:
            self._low = max(self._low, self._at + 1)
        else:
            self._high = min(self._high, self._at - 1)
        if self._low > self._high:
            self.finished = True
            return
        factor = self.rate.value / achieved if achieved > 0.0 else 2.0
        guess = len(self._values) - round(above * factor)
        self._at = guess if self._low <= guess <= self._high else (self._low + self._high) // 2
