"""Thresholds of rare false alarms, from many hours of benign driving that are looked at piece by piece."""

from dataclasses import dataclass, field, replace

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES, Calibrated, Rate, Search, replay
from gpsec.detection.extremes import counted_interval, modelled_thresholds
from gpsec.detection.gate import GATED_AT, GATED_BY, search_gate
from gpsec.detection.logs import Grid
from gpsec.detection.monitored import monitored
from gpsec.detection.near import KEPT_PER_HOUR, NearVehicles, level_of

RARE = {name: rate for name, rate in RATES.items() if rate.per_hour and rate.value < KEPT_PER_HOUR}


@dataclass
class Harvest:
    """What is kept of the hours that one detector has seen.

    Attributes:
        detector: built for the one profile of the logs.
        settle_s: samples before that age of a vehicle are seen by the detector but do not count.
        hours: vehicle-hours.
        peaks: largest settled statistic of each vehicle, piece by piece.
        near: the vehicles that reached the level.
    """

    detector: Detector
    settle_s: float
    hours: float = 0.0
    peaks: list[Floats] = field(default_factory=list)
    near: NearVehicles = field(default_factory=NearVehicles)

    @property
    def level(self) -> float:
        """Of the statistic; over it vehicles are kept, and the tail is fitted."""
        return level_of(np.concatenate([*self.peaks, np.zeros(0)]), self.hours)

    def take(self, grid: Grid, threads: Threads | None = None) -> None:
        """Look at further benign vehicles, and keep those that reached the level."""
        peak = self.look(grid, threads)
        self.near.take(replace(grid, inputs=None), peak[np.newaxis], [self.level])

    def look(self, grid: Grid, threads: Threads | None = None) -> Floats:
        """Look at (V,) further benign vehicles; return the peak of each, settled or not."""
        opened = replay(self.detector, grid, np.inf, self.settle_s, threads)
        self.hours += opened.hours
        self.peaks.append(opened.settled_peak)
        return opened.peak

    def calibrated(self, threads: Threads | None = None) -> dict[str, Calibrated | None]:
        """Return the threshold of each of `RARE`: counted where that can be, else from a model of extreme values."""
        return self.calibrated_on(list(self.near.groups()), np.concatenate(self.peaks), threads)

    def calibrated_on(
        self, near: list[Grid], peaks: Floats, threads: Threads | None = None
    ) -> dict[str, Calibrated | None]:
        """Return what `calibrated` does, on vehicles of which these are all that reached the level.

        Args:
            near: the vehicles.
            peaks: while settled, of these and any others.
            threads: for the kernels.
        """
        over = peaks[peaks > self.level]
        found: dict[str, Calibrated | None] = {
            name: None if rate.model else self._counted(rate, near, np.unique(over), threads)
            for name, rate in RARE.items()
        }
        names = [name for name, rate in RARE.items() if rate.model]
        modelled = modelled_thresholds(over, self.hours, self.level, [RARE[name].value for name in names])
        for name, one in zip(names, modelled or (), strict=False):
            found[name] = Calibrated(one.threshold, RARE[name].value, one.lo, one.hi, model=True)
        return found

    def _counted(
        self, rate: Rate, near: list[Grid], values: Floats, threads: Threads | None = None
    ) -> Calibrated | None:
        """Search for a threshold as `thresholds_by_rate` does, among the vehicles that were kept."""
        wanted = rate.value * self.hours
        if wanted < MIN_EVENTS or not len(values):
            return None
        search = Search(rate, values, max(len(values) - round(wanted) - 1, 0))
        for _ in range(MAX_ROUNDS):
            search.learn(self.onsets(search.trial, near, threads) / self.hours)
            if search.finished:
                break
        return None if search.best is None else self.bounded(search.best)

    def bounded(self, found: Calibrated) -> Calibrated:
        """Return a threshold that was counted with the interval of its rate."""
        bounds = counted_interval(round(found.achieved * self.hours), self.hours)
        return Calibrated(found.threshold, found.achieved, *bounds)

    def onsets(self, threshold: float, near: list[Grid], threads: Threads | None = None) -> int:
        """Return the alarms that begin in the closed loop."""
        return sum(replay(self.detector, grid, threshold, self.settle_s, threads).onsets for grid in near)


@dataclass
class GatedHarvest:
    """The harvests of detectors that read the monitor, whose gate is known only in the end.

    Attributes:
        harvests: of each of them.
        near: vehicles that reached the level of one of them behind an open gate, with what the monitor is handed.
    """

    harvests: list[Harvest]
    near: NearVehicles = field(default_factory=NearVehicles)

    def take(self, grid: Grid, threads: Threads | None = None) -> None:
        """Look at further benign vehicles."""
        opened = monitored(grid, np.inf, threads)
        peaks = np.array([harvest.look(opened, threads) for harvest in self.harvests])
        self.near.take(grid, peaks, [harvest.level for harvest in self.harvests])

    def calibrated(self, gate: float, threads: Threads | None = None) -> dict[str, dict[str, Calibrated | None]]:
        """Return the thresholds of each detector, as `Harvest.calibrated` does.

        The gate becomes the threshold of `joint` at 0.1/h; where these hours do not tell it, it stays `gate`.
        """
        names = [harvest.detector.name for harvest in self.harvests]
        first = self.harvests[names.index(GATED_BY)]
        found = self._gate(names.index(GATED_BY), threads)
        gate = gate if found is None else found.threshold
        gated = [monitored(grid, gate, threads) for grid in self.near.groups()]
        thresholds = {}
        for name, harvest in zip(names, self.harvests, strict=True):
            # Vehicles that are not near are below all levels, and so below the gate: it changes nothing for them.
            behind = [replay(harvest.detector, grid, np.inf, harvest.settle_s, threads).settled_peak for grid in gated]
            thresholds[name] = harvest.calibrated_on(gated, np.concatenate(behind), threads)
        if found is not None:
            thresholds[GATED_BY][GATED_AT] = first.bounded(found)
        return thresholds

    def _gate(self, place: int, threads: Threads | None = None) -> Calibrated | None:
        """Search for the gate among the vehicles that came near it."""
        first = self.harvests[place]
        own = NearVehicles()
        for grid, peaks in zip(self.near.grids, self.near.peaks, strict=True):
            own.take(grid, peaks[[place]], [first.level])
        opened = [monitored(grid, np.inf, threads, looks_back=False) for grid in own.groups()]
        near = Grid.joined(opened)
        counts = replace(replay(first.detector, near, np.inf, first.settle_s, threads), hours=first.hours)
        return search_gate(near, counts, RARE[GATED_AT], first.settle_s, threads)
