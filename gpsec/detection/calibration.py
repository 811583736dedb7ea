"""Thresholds: every detector gets the same false-alarm rate, measured in the closed loop on benign runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import nearest
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector
from gpsec.detection.learned import OnStage, silent
from gpsec.detection.logs import Grid
from gpsec.types.answers import Answers


@dataclass(frozen=True)
class Rate:
    """A false-alarm rate: alarmed samples per scored sample, or alarms that begin per vehicle-hour.

    Attributes:
        value: of the rate.
        per_hour: it is one per vehicle-hour.
        model: too rare to be counted; a model of extreme values (`detection.extremes`) gives the threshold.
    """

    value: float
    per_hour: bool
    model: bool = False


RATES = {
    "1e-3/sample": Rate(1e-3, False),
    "1e-4/sample": Rate(1e-4, False),
    "1/h": Rate(1.0, True),
    "0.1/h": Rate(0.1, True),
    "0.01/h": Rate(0.01, True, model=True),
    "1e-3/h": Rate(1e-3, True, model=True),
}


def nearest_rates(asked: str, known: Sequence[str] = tuple(RATES)) -> str:
    """Return a hint at the rates that there are: the nearest one to `asked`, and those of the model."""
    number, _, unit = asked.partition("/")
    try:
        value = abs(float(number))
    except ValueError:
        value = 0.0
    alike = [name for name in known if value > 0.0 and name.partition("/")[2] == unit]
    modelled = [name for name in known if RATES[name].model]
    more = f"; by the model of extreme values: {', '.join(modelled)}" if modelled else ""
    if not alike:
        return f"{nearest(asked, known)}{more}" if known else "none is calibrated"
    best = min(alike, key=lambda name: abs(log(RATES[name].value / value)))
    return f"the nearest is '{best}' (calibrated: {', '.join(known)}{more})"


# A rate is only calibrated where at least so many false alarms (or alarmed samples) are expected in the data.
MIN_EVENTS = 10.0
# The achieved rate may differ from the asked one by this share; few events allow no better.
TOLERANCE = 0.05
MAX_ROUNDS = 8


@dataclass(frozen=True)
class Calibrated:
    """A threshold and the false-alarm rate that it had on the calibration data.

    Attributes:
        threshold: over which a statistic is an alarm.
        achieved: the rate; by the model, the one that was asked for.
        lo, hi: its 95 % interval, None where there is none; by the model, that of the fit as well.
        model: it is not counted, but from a model of extreme values.
    """

    threshold: float
    achieved: float
    lo: float | None = None
    hi: float | None = None
    model: bool = False


@dataclass(frozen=True)
class ReplayCounts:
    """What a detector did on a grid of V vehicles; only settled samples count, but for the peak.

    Attributes:
        scored, alarmed: samples that were scored, and those of them in alarm.
        onsets: alarms that began.
        hours: vehicle-hours.
        statistic: (scored,) all scored values.
        peak: (V,) largest statistic of a vehicle, settled or not.
        settled_peak: (V,) the largest while settled.
    """

    scored: int
    alarmed: int
    onsets: int
    hours: float
    statistic: Floats
    peak: Floats
    settled_peak: Floats

    def rate(self, like: Rate, whole: "ReplayCounts") -> float:
        """Return the false-alarm rate of a kind, where only some vehicles of the `whole` were replayed."""
        return self.onsets / whole.hours if like.per_hour else self.alarmed / whole.scored

    def expected(self, rate: Rate) -> float:
        """Return how many events the data would hold at exactly that rate."""
        return float(rate.value * (self.hours if rate.per_hour else self.scored))


def replay(
    detector: Detector, grid: Grid, threshold: float, settle_s: float, threads: Threads | None = None
) -> ReplayCounts:
    """Run a detector over a grid exactly as in the loop."""
    vehicles = len(grid.length)
    state = detector.new_state(vehicles).now
    answers = Table(Answers, vehicles, detectors=1, defences=0).now
    before: Flags = np.zeros(vehicles, np.bool_)
    peak, settled_peak = np.zeros(vehicles), np.zeros(vehicles)
    settle_steps = round(settle_s / grid.step_s)
    alarmed, onsets, samples = 0, 0, 0
    values = [np.zeros(0)]
    for step in range(len(grid.valid)):
        observation = grid.observe(step)
        m = len(observation.rows)
        detector.update(state, observation, np.full(m, threshold), answers, 0, threads)
        statistic, hit, alarm = answers.statistic[:m, 0], answers.scored[:m, 0], answers.alarm[:m, 0]
        np.maximum(peak[:m], statistic, out=peak[:m])
        if step >= settle_steps:
            np.maximum(settled_peak[:m], statistic, out=settled_peak[:m])
            samples += m
            alarmed += int((hit & alarm).sum())
            onsets += int((alarm & ~before[:m]).sum())
            values.append(statistic[hit])
        before[:m] = alarm
    scores = np.concatenate(values)
    hours = samples * grid.step_s / 3600.0
    return ReplayCounts(len(scores), alarmed, onsets, hours, scores, peak, settled_peak)


def thresholds_by_rate(
    detector: Detector,
    grid: Grid,
    settle_s: float = 10.0,
    progress: OnStage = silent,
    threads: Threads | None = None,
) -> dict[str, Calibrated | None]:
    """Return the threshold for each of `RATES`, None where there is too little data to tell.

    The statistic of a detector may depend on its own alarm, so a threshold is not read off one distribution: it is the
    start of a bisection in which each round replays the closed loop. Until its first alarm a vehicle does as in the
    open loop, so only those are replayed whose statistic went over the threshold there: the others have no alarm.

    Args:
        detector: built for the one profile of the grid.
        grid: benign vehicles that the detector was not trained on.
        settle_s: samples before that age of a vehicle are seen by the detector but do not count.
        progress: told of every rate.
        threads: for the kernels.
    """
    progress(f"calibrating {detector.name}", 0, 1 + len(RATES))
    opened = replay(detector, grid, np.inf, settle_s, threads)
    values = np.unique(opened.statistic)
    answer: dict[str, Calibrated | None] = {}
    for done, (name, rate) in enumerate(RATES.items()):
        progress(f"calibrating {detector.name}", 1 + done, 1 + len(RATES))
        answer[name] = None
        if rate.model or opened.expected(rate) < MIN_EVENTS:
            continue
        search = Search.start(rate, values, opened)
        for _ in range(MAX_ROUNDS):
            closed = replay(detector, grid.select(opened.peak > search.trial), search.trial, settle_s, threads)
            search.learn(closed.rate(rate, opened))
            if search.finished:
                break
        answer[name] = search.best
    progress(f"calibrating {detector.name}", 1 + len(RATES), 1 + len(RATES))
    return answer


class Search:
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
    def start(cls, rate: Rate, values: Floats, opened: ReplayCounts) -> "Search":
        """Begin at the quantile of the open loop."""
        # An onset lasts for some samples; five is only a guess to begin with.
        share = 5.0 * opened.expected(rate) / opened.scored if rate.per_hour else rate.value
        wanted = float(np.quantile(opened.statistic, max(0.0, 1.0 - share)))
        return cls(rate, values, int(np.searchsorted(values, wanted)))

    @property
    def trial(self) -> float:
        """The threshold that is to be tried next."""
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
