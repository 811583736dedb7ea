"""The batched engine: lanes, residual, detectors and filters of all tracks at once."""

from collections.abc import Sequence
from typing import Any

from gpsec.association.associating import Associating
from gpsec.attacks.probing import Probed, Question
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detection
from gpsec.detection.monitor_state import MonitorState
from gpsec.localization.branches import LocalizationState
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.pipeline.perception import Perception, StepInputs
from gpsec.pipeline.probing import Probing
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class BatchedMethod:
    """The kernels: all tracks at once."""

    def __init__(
        self,
        world: World,
        association: Associating,
        detection: Detection,
        localization: Localization,
        *,
        copies: bool = False,
    ) -> None:
        """Prepare for tracks; with `copies`, an attacker follows each with detectors of its own."""
        self._perception = Perception(world, association, detection, len(localization.responses))
        self._probing = Probing(world, association, detection, copies=copies)
        self._localization = localization
        self._filters = localization.new_state(1)

    @property
    def answers(self) -> Answers:
        """What was found in the last step."""
        return self._perception.answers

    def _states(self) -> Sequence[Table[Any] | LocalizationState]:
        return [*self._perception.tables(), *self._probing.tables(), self._filters]

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        for state in self._states():
            state.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        for state in self._states():
            state.reset(rows)

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where the tracks `source` are."""
        for state in self._states():
            state.copy(source, target)

    @property
    def filters(self) -> LocalizationState:
        """State of the filters, for consistency checks."""
        return self._filters

    @property
    def monitor(self) -> MonitorState | None:
        """State of the monitor, if a detector reads it."""
        return self._perception.monitor

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
        """Say which lane each track is on, form the residuals, ask the detectors, run the filters."""
        inputs = StepInputs(number, tracks, vehicles, seen, threads)
        self._perception.step(rows, inputs, watch)
        localization, filters = self._localization, self._filters
        localization.propagate(filters, rows, tracks, vehicles, seen, self.answers.alarm, threads)
        watch.lap("EKF")
        localization.correct(filters, rows, tracks, vehicles, seen, threads)
        watch.lap("UKF")
        localization.report(filters, rows, self.answers, threads)
        watch.lap("outcomes")
        self._probing.follow(rows, inputs)
        watch.lap("attacks")

    def probe(
        self, number: int, asked: Question, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads
    ) -> Probed:
        """Return what detectors would find of other fixes in step `number`, which has not been taken yet."""
        return self._probing.ask(asked, self._perception, StepInputs(number, tracks, vehicles, seen, threads))
