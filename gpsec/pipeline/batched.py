"""The batched engine: lanes, residual, detectors and filters of all tracks at once."""

from collections.abc import Sequence
from typing import Any

from gpsec.association.associating import Associating
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detection, Detector, LabelledDetector, Observation
from gpsec.detection.channels import Channels, first_channels
from gpsec.detection.monitor import Monitor
from gpsec.detection.monitor_state import MonitorState
from gpsec.detection.pairing import Pending
from gpsec.detection.points import Watch
from gpsec.detection.residual import Residuals
from gpsec.localization.branches import LocalizationState
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class BatchedMethod:
    """The kernels: all tracks at once."""

    def __init__(
        self, world: World, association: Associating, detection: Detection, localization: Localization
    ) -> None:
        self._world = world
        self._association = association
        self._lanes = association.new_state(1)
        self._detection = detection
        self._localization = localization
        self._residuals = Residuals(world.hd_map, detection.sampling)
        self._pending = Table(Pending)
        self._watches: list[tuple[str, Watch]] = []
        self._labelled: list[tuple[str, LabelledDetector, int]] = []
        for detector in {id(one): one for one in detection.detectors}.values():
            columns = [k for k, other in enumerate(detection.detectors) if other is detector]
            if isinstance(detector, LabelledDetector):
                self._labelled += [(detector.name, detector, k) for k in columns]
            else:
                self._watches.append((detector.name, Watch(detector, columns)))
        looks_back = any(isinstance(one, Detector) and one.looks_back for one in detection.detectors)
        self._monitor = None if detection.monitor is None else Monitor(detection.monitor, looks_back)
        self._unwatched = Table(Channels)
        self._filters = localization.new_state(1)
        lengths = {"detectors": len(detection.names), "defences": len(localization.responses)}
        self._answers = Table(Answers, **lengths)

    @property
    def answers(self) -> Answers:
        """What was found in the last step."""
        return self._answers.now

    def _states(self) -> Sequence[Table[Any] | LocalizationState]:
        return [
            self._answers,
            self._lanes,
            self._pending,
            self._filters,
            *([] if self._monitor is None else self._monitor.tables),
            *(state for _, watch in self._watches for state in watch.states()),
        ]

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
        return None if self._monitor is None else self._monitor.now

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
        self._association.update(self._lanes.now, rows, tracks, vehicles, seen, threads)
        watch.lap("association")
        self._residuals.update(number, self._pending.now, rows, tracks, vehicles, seen, threads)
        watch.lap("matching")
        if self._monitor is None:
            channels = first_channels(self._unwatched, len(rows))
        else:
            channels = self._monitor.update(number, self._pending.now, rows, tracks, vehicles, seen, threads)
            watch.lap("monitor")
        self._detect(rows, channels, tracks, vehicles, seen, threads, watch)
        localization, filters = self._localization, self._filters
        localization.propagate(filters, rows, tracks, vehicles, seen, self.answers.alarm, threads)
        watch.lap("EKF")
        localization.correct(filters, rows, tracks, vehicles, seen, threads)
        watch.lap("UKF")
        localization.report(filters, rows, self.answers, threads)
        watch.lap("outcomes")

    def _detect(
        self,
        rows: Ints,
        channels: Channels,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
        watch: Stopwatch,
    ) -> None:
        vehicle = tracks.vehicle[rows]
        profile = vehicles.profile[vehicle]
        observation = Observation(
            rows=rows,
            profile=profile,
            residual_m=tracks.residual_m[rows],
            valid=tracks.residual_valid[rows],
            elapsed_steps=self._pending.now.elapsed_steps[rows],
            scale_m=self._detection.scale_m[profile],
            speed_mps=seen.speed_mps[vehicle],
            curvature_per_m=self._pending.now.curvature_per_m[rows],
            camera_sigma_m=self._pending.now.sigma_m[rows],
            channels=channels,
            step_s=self._world.step_s,
            unmatched=tracks.unmatched[rows],
        )
        attacked = tracks.attacked[rows]
        watch.lap("matching")
        thresholds = self._detection.thresholds[profile]
        for name, looking in self._watches:
            looking.update(observation, thresholds, self.answers, threads)
            watch.lap(f"detector {name}")
        for name, told, k in self._labelled:
            told.update(rows, attacked, self.answers, k)
            watch.lap(f"detector {name}")
