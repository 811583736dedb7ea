"""Thresholds of rare false alarms, from many hours of benign driving that are looked at piece by piece."""

from dataclasses import dataclass, field

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES, Calibrated, Rate, Search, replay
from gpsec.detection.extremes import counted_interval, modelled_thresholds
from gpsec.detection.logs import Grid

# Peaks are kept from the level on that so many vehicles an hour reach: over it the tail is fitted.
LEVEL_PER_HOUR = 1.0
RARE = {name: rate for name, rate in RATES.items() if rate.per_hour and rate.value < LEVEL_PER_HOUR}


@dataclass
class Harvest:
    """What is kept of the hours that one detector has seen.

    Attributes:
        detector: built for the one profile of the logs.
        settle_s: samples before that age of a vehicle are seen by the detector but do not count.
        hours: vehicle-hours.
        level: of the statistic, from which on vehicles are kept.
        peaks: largest settled statistic of each vehicle, piece by piece.
        near: the vehicles that reached the level.
    """

    detector: Detector
    settle_s: float
    hours: float = 0.0
    level: float = 0.0
    peaks: list[Floats] = field(default_factory=list)
    near: list[Grid] = field(default_factory=list)

    def take(self, grid: Grid, threads: Threads | None = None) -> None:
        """Look at further benign vehicles; the first ones decide on the level."""
        opened = replay(self.detector, grid, np.inf, self.settle_s, threads)
        if not self.peaks:
            reached = min(max(round(LEVEL_PER_HOUR * opened.hours), 1), len(opened.settled_peak))
            self.level = float(np.sort(opened.settled_peak)[-reached])
        self.hours += opened.hours
        self.peaks.append(opened.settled_peak)
        self.near.append(grid.select(opened.peak > self.level))

    def calibrated(self, threads: Threads | None = None) -> dict[str, Calibrated | None]:
        """Return the threshold of each of `RARE`: counted where that can be, else from a model of extreme values."""
        peaks = np.concatenate(self.peaks)
        found: dict[str, Calibrated | None] = {
            name: None if rate.model else self._counted(rate, np.unique(peaks[peaks > self.level]), threads)
            for name, rate in RARE.items()
        }
        names = [name for name, rate in RARE.items() if rate.model]
        modelled = modelled_thresholds(peaks, self.hours, self.level, [RARE[name].value for name in names])
        for name, one in zip(names, modelled or (), strict=False):
            found[name] = Calibrated(one.threshold, RARE[name].value, one.lo, one.hi, model=True)
        return found

    def _counted(self, rate: Rate, values: Floats, threads: Threads | None) -> Calibrated | None:
        """Search for a threshold as `thresholds_by_rate` does, among the vehicles that were kept."""
        wanted = rate.value * self.hours
        if wanted < MIN_EVENTS or not len(values):
            return None
        search = Search(rate, values, max(len(values) - round(wanted) - 1, 0))
        for _ in range(MAX_ROUNDS):
            search.learn(self._onsets(search.trial, threads) / self.hours)
            if search.finished:
                break
        best = search.best
        if best is None:
            return None
        bounds = counted_interval(round(best.achieved * self.hours), self.hours)
        return Calibrated(best.threshold, best.achieved, *bounds)

    def _onsets(self, threshold: float, threads: Threads | None) -> int:
        """Return the alarms that begin in the closed loop."""
        return sum(
            replay(self.detector, grid, threshold, self.settle_s, threads).onsets
            for grid in self.near
            if len(grid.length)
        )
