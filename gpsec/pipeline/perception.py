"""What comes before filters: lanes, residuals, the monitor and the detectors of rows, with all they remember."""

from collections.abc import Collection
from typing import Any, NamedTuple

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
from gpsec.localization.world import World
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class StepInputs(NamedTuple):
    """What step `number` has for rows of `tracks`, and the threads to work them out.

    Attributes:
        number: from 0.
        tracks, vehicles, seen: by track row and by vehicle row.
        threads: for kernels.
    """

    number: int
    tracks: Tracks
    vehicles: Vehicles
    seen: Measurements
    threads: Threads


class Perception:
    """The detectors of a run at work on rows, or those of some operating points."""

    def __init__(
        self,
        world: World,
        association: Associating,
        detection: Detection,
        defences: int = 0,
        only: Collection[int] | None = None,
    ) -> None:
        """Begin without rows.

        Args:
            world: the map and the step length.
            association: how rows know their lane.
            detection: the detectors.
            defences: how many the answers have room for.
            only: columns of operating points; detectors that have none of them are left out. None for all.
        """
        self._step_s = world.step_s
        self._association = association
        self._detection = detection
        self._lanes = association.new_state(1)
        self._residuals = Residuals(world.hd_map, detection.sampling)
        self._pending = Table(Pending)
        self._watches: dict[str, Watch] = {}
        self._labelled: list[tuple[str, LabelledDetector, int]] = []
        chosen: list[Detector] = []
        for detector in {id(one): one for one in detection.detectors}.values():
            columns = [k for k, other in enumerate(detection.detectors) if other is detector]
            if only is not None and not set(columns) & set(only):
                continue
            if isinstance(detector, LabelledDetector):
                self._labelled += [(detector.name, detector, k) for k in columns]
            else:
                self._watches[detector.name] = Watch(detector, columns)
                chosen.append(detector)
        runs = detection.monitor is not None and (only is None or any(one.reads_monitor for one in chosen))
        looks_back = any(one.looks_back for one in chosen)
        self._monitor = Monitor(detection.monitor, looks_back) if runs and detection.monitor is not None else None
        self._unwatched = Table(Channels)
        self._answers = Table(Answers, detectors=len(detection.names), defences=defences)

    @property
    def answers(self) -> Answers:
        """What was found in the last step."""
        return self._answers.now

    @property
    def monitor(self) -> MonitorState | None:
        """State of the monitor, if a detector reads it."""
        return None if self._monitor is None else self._monitor.now

    def tables(self) -> list[Table[Any]]:
        """Return all that is remembered of rows."""
        return [self._answers, *self._memory(set(self._watches), self._monitor)]

    def _memory(self, names: Collection[str], monitor: Monitor | None) -> list[Table[Any]]:
        """Return what is remembered for the detectors `names`, and for as much as `monitor` remembers."""
        own = [] if self._monitor is None or monitor is None else self._monitor.tables[: len(monitor.tables)]
        watched = [state for name, watch in self._watches.items() if name in names for state in watch.states()]
        return [self._lanes, self._pending, *own, *watched]

    def take(self, other: "Perception", rows: Ints) -> None:
        """Begin rows 0 … n - 1 where the (n,) `rows` of another perception of the same detectors are."""
        n = len(rows)
        self._answers.grow(n)
        mine, theirs = self.answers, other.answers
        for name in ("statistic", "scored", "alarm", "unscored_steps"):
            getattr(mine, name)[:n] = getattr(theirs, name)[rows]
        names = set(self._watches)
        for own, given in zip(self._memory(names, self._monitor), other._memory(names, self._monitor), strict=True):
            own.grow(n)
            for one, another in zip(own.arrays(), given.arrays(), strict=True):
                one[:n] = another[rows]

    def step(self, rows: Ints, inputs: StepInputs, watch: Stopwatch) -> None:
        """Take a step of some track rows: lanes, residuals, and the answers of the detectors."""
        number, tracks, vehicles, seen, threads = inputs
        self._association.update(self._lanes.now, rows, tracks, vehicles, seen, threads)
        watch.lap("association")
        self._residuals.update(number, self._pending.now, rows, tracks, vehicles, seen, threads)
        watch.lap("matching")
        if self._monitor is None:
            channels = first_channels(self._unwatched, len(rows))
        else:
            channels = self._monitor.update(number, self._pending.now, rows, tracks, vehicles, seen, threads)
            watch.lap("monitor")
        self._detect(rows, channels, inputs, watch)

    def _detect(self, rows: Ints, channels: Channels, inputs: StepInputs, watch: Stopwatch) -> None:
        tracks, vehicles, seen = inputs.tracks, inputs.vehicles, inputs.seen
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
            step_s=self._step_s,
            unmatched=tracks.unmatched[rows],
        )
        attacked = tracks.attacked[rows]
        watch.lap("matching")
        thresholds = self._detection.thresholds[profile]
        for name, looking in self._watches.items():
            looking.update(observation, thresholds, self.answers, inputs.threads)
            watch.lap(f"detector {name}")
        for name, told, k in self._labelled:
            told.update(rows, attacked, self.answers, k)
            watch.lap(f"detector {name}")
