"""Thresholds of rare false alarms, from many hours of benign driving that are looked at piece by piece."""

from dataclasses import dataclass, field, replace

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES, Calibrated, Rate, Search, replay
from gpsec.detection.extremes import counted_interval, modelled_thresholds
from gpsec.detection.gate import GATED_AT, GATED_BY, search_gate
from gpsec.detection.logs import Grid
from gpsec.detection.monitored import monitored

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
        """Look at further benign vehicles, and keep those that reached the level."""
        self.near.append(grid.select(self.look(grid, threads)))

    def look(self, grid: Grid, threads: Threads | None = None) -> Flags:
        """Look at (V,) further benign vehicles; return which of them reached the level, on which the first decide."""
        opened = replay(self.detector, grid, np.inf, self.settle_s, threads)
        if not self.peaks:
            reached = min(max(round(LEVEL_PER_HOUR * opened.hours), 1), len(opened.settled_peak))
            self.level = float(np.sort(opened.settled_peak)[-reached])
        self.hours += opened.hours
        self.peaks.append(opened.settled_peak)
        return opened.peak > self.level

    def calibrated(self, threads: Threads | None = None) -> dict[str, Calibrated | None]:
        """Return the threshold of each of `RARE`: counted where that can be, else from a model of extreme values."""
        self.near = [Grid.joined(self.near)]
        peaks = np.concatenate(self.peaks)
        found: dict[str, Calibrated | None] = {
            name: None if rate.model else self._counted(rate, threads) for name, rate in RARE.items()
        }
        names = [name for name, rate in RARE.items() if rate.model]
        modelled = modelled_thresholds(peaks, self.hours, self.level, [RARE[name].value for name in names])
        for name, one in zip(names, modelled or (), strict=False):
            found[name] = Calibrated(one.threshold, RARE[name].value, one.lo, one.hi, model=True)
        return found

    def _counted(self, rate: Rate, threads: Threads | None = None) -> Calibrated | None:
        """Search for a threshold as `thresholds_by_rate` does, among the vehicles that were kept."""
        peaks = np.concatenate(self.peaks)
        values = np.unique(peaks[peaks > self.level])
        wanted = rate.value * self.hours
        if wanted < MIN_EVENTS or not len(values):
            return None
        search = Search(rate, values, max(len(values) - round(wanted) - 1, 0))
        for _ in range(MAX_ROUNDS):
            search.learn(self._onsets(search.trial, threads) / self.hours)
            if search.finished:
                break
        return None if search.best is None else self.bounded(search.best)

    def bounded(self, found: Calibrated) -> Calibrated:
        """Return a threshold that was counted with the interval of its rate."""
        bounds = counted_interval(round(found.achieved * self.hours), self.hours)
        return Calibrated(found.threshold, found.achieved, *bounds)

    def _onsets(self, threshold: float, threads: Threads | None) -> int:
        """Return the alarms that begin in the closed loop."""
        return sum(
            replay(self.detector, grid, threshold, self.settle_s, threads).onsets
            for grid in self.near
            if len(grid.length)
        )


@dataclass
class GatedHarvest:
    """The harvests of detectors that read the monitor, whose gate is known only in the end.

    Attributes:
        harvests: of each of them; what they keep is empty before the end.
        near: vehicles that reached the level of one of them behind an open gate, with what the monitor is handed.
    """

    harvests: list[Harvest]
    near: list[Grid] = field(default_factory=list)

    def take(self, grid: Grid, threads: Threads | None = None) -> None:
        """Look at further benign vehicles."""
        opened = monitored(grid, np.inf, threads)
        reached = np.logical_or.reduce([harvest.look(opened, threads) for harvest in self.harvests])
        self.near.append(grid.select(reached))

    def calibrated(self, gate: float, threads: Threads | None = None) -> dict[str, dict[str, Calibrated | None]]:
        """Return the thresholds of each detector, as `Harvest.calibrated` does.

        The gate becomes the threshold of `joint` at 0.1/h; where these hours do not tell it, it stays `gate`.
        """
        near = Grid.joined(self.near)
        by_name = {harvest.detector.name: harvest for harvest in self.harvests}
        first = by_name[GATED_BY]
        opened = monitored(near, np.inf, threads, looks_back=False)
        counts = replace(replay(first.detector, opened, np.inf, first.settle_s, threads), hours=first.hours)
        found = search_gate(opened, counts, RARE[GATED_AT], first.settle_s, threads)
        gate = gate if found is None else found.threshold
        gated = monitored(near, gate, threads)
        thresholds = {}
        for name, harvest in by_name.items():
            # Vehicles that are not near are below all levels, and so below the gate: it changes nothing for them.
            harvest.near = [gated]
            harvest.peaks = [replay(harvest.detector, gated, np.inf, harvest.settle_s, threads).settled_peak]
            thresholds[name] = harvest.calibrated(threads)
        if found is not None:
            thresholds[GATED_BY][GATED_AT] = first.bounded(found)
        return thresholds
