"""Vehicles that came near a rare threshold: few of many hours, which are replayed in the closed loop."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.detection.logs import Grid

# Vehicles that are kept of an hour, five times what 0.1/h asks for, and of the first hours, whose order is chance.
KEPT_PER_HOUR = 0.5
KEPT_AT_LEAST = 30
# Vehicles of a like length that are replayed together: more would take memory, and time is the same.
_TOGETHER = 128


def level_of(peaks: Floats, hours: float) -> float:
    """Return the level that as many of the (V,) peaks exceed as are kept of so many hours."""
    kept = min(max(round(KEPT_PER_HOUR * hours), KEPT_AT_LEAST), len(peaks) - 1)
    return float(np.sort(peaks)[-1 - kept]) if kept >= 0 else 0.0


@dataclass
class NearVehicles:
    """Vehicles with the (V,) peaks of each of K statistics.

    Attributes:
        grids: the vehicles, piece by piece.
        peaks: (K, V) of each piece.
    """

    grids: list[Grid] = field(default_factory=list)
    peaks: list[Floats] = field(default_factory=list)

    def take(self, grid: Grid, peaks: Floats, levels: Sequence[float]) -> None:
        """Add those of a grid of which a peak exceeds its level, and drop whose peaks no longer do."""
        self.grids, self.peaks = [*self.grids, grid], [*self.peaks, peaks]
        for place, (known, own) in enumerate(zip(self.grids, self.peaks, strict=True)):
            over: Flags = np.any(own > np.asarray(levels)[:, np.newaxis], axis=0)
            if not over.all():
                self.grids[place], self.peaks[place] = known.select(over), own[:, over]

    def groups(self) -> Iterator[Grid]:
        """Yield the vehicles in groups of a like length, the longest first."""
        order = np.argsort(-np.concatenate([grid.length for grid in self.grids]), kind="stable")
        piece = np.repeat(np.arange(len(self.grids)), [len(grid.length) for grid in self.grids])
        column = np.concatenate([np.arange(len(grid.length)) for grid in self.grids])
        for first in range(0, len(order), _TOGETHER):
            own = order[first : first + _TOGETHER]
            chosen = [(place, np.sort(column[own[piece[own] == place]])) for place in np.unique(piece[own])]
            yield Grid.joined([_columns(self.grids[place], columns) for place, columns in chosen])


def _columns(grid: Grid, columns: np.ndarray) -> Grid:
    return grid.select(np.isin(np.arange(len(grid.length)), columns))
