"""What two engines have in common: the batched kernels (`gpsec.pipeline`) and the reference (`gpsec.reference`)."""

from typing import Protocol

from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.threads import Threads
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class Method(Protocol):
    """Residual, detectors and filters of every track."""

    @property
    def answers(self) -> Answers:
        """What was found in the last step."""
        ...

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        ...

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        ...

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where the tracks `source` are."""
        ...

    def step(
        self,
        number: int,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
        watch: Stopwatch,
    ) -> None:
        """Take step `number` (from 0) of the track rows `rows`; sets residuals in `tracks` and `answers`."""
        ...
