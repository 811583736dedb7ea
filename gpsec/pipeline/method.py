"""The method under test: what a vehicle computes from its sensors. Two engines implement it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.detection.base import Detector, LabelledDetector, Observation
from gpsec.fleet import Measurements, Rows, Tracks, Vehicles
from gpsec.hdmap.map import HDMap
from gpsec.hdmap.matching import lateral_residual
from gpsec.localization.responses import World
from gpsec.localization.state import FilterState
from gpsec.localization.switch import Localization
from gpsec.pipeline.stopwatch import Stopwatch
from gpsec.threads import Threads


@dataclass
class Answers(Rows):
    """What K detectors and D defences say of M tracks after a step.

    Attributes:
        statistic, scored, alarm: (M, K) of the detectors.
        estimate_m: (M, D, 2) of the rear axle in the net's frame.
        isolated: (M, D) GNSS is not used.

    """

    statistic: Floats
    scored: Flags
    alarm: Flags
    estimate_m: Floats
    isolated: Flags

    @classmethod
    def empty(cls, capacity: int, detectors: int, defences: int) -> Self:
        """Return `capacity` rows without an answer."""
        return cls(
            statistic=np.zeros((capacity, detectors)),
            scored=np.zeros((capacity, detectors), np.bool_),
            alarm=np.zeros((capacity, detectors), np.bool_),
            estimate_m=np.zeros((capacity, defences, 2)),
            isolated=np.zeros((capacity, defences), np.bool_),
        )


class Method(Protocol):
    """Residual, detectors and filters of every track.

    Attributes:
        answers: what was found in the last step.

    """

    answers: Answers

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
        self, rows: Ints, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads, watch: Stopwatch
    ) -> None:
        """Take one step of the track rows `rows`; sets residuals in `tracks` and `answers`."""
        ...


@dataclass(frozen=True)
class Watchers:
    """The detectors of a run.

    Attributes:
        names: of the K detectors.
        detectors: themselves.
        thresholds: (profiles, K).
        scale_m: (profiles,) standard deviation of the residual that each profile promises.

    """

    names: tuple[str, ...]
    detectors: tuple[Detector | LabelledDetector, ...]
    thresholds: Floats
    scale_m: Floats


class BatchedMethod:
    """The kernels: all tracks at once."""

    def __init__(self, hd_map: HDMap, world: World, watchers: Watchers, localization: Localization) -> None:
        self._map = hd_map
        self._world = world
        self._watchers = watchers
        self._localization = localization
        self._detector_states: list[Rows | None] = [
            None if isinstance(detector, LabelledDetector) else detector.new_state(1) for detector in watchers.detectors
        ]
        self._filters: FilterState = localization.new_state(1)
        self.answers = Answers.empty(1, len(watchers.names), len(localization.responses))

    def _states(self) -> Sequence[Rows]:
        return [self.answers, self._filters, *(state for state in self._detector_states if state is not None)]

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
    def filters(self) -> FilterState:
        """State of the filters, for consistency checks."""
        return self._filters

    def step(
        self, rows: Ints, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads, watch: Stopwatch
    ) -> None:
        """Match the fixes, ask the detectors, run the filters."""
        world = self._world
        threads.run(
            lateral_residual,
            rows,
            world.lanes,
            world.index,
            world.mode,
            world.layer,
            tracks.vehicle,
            tracks.fix_m,
            tracks.fix_valid,
            tracks.segment,
            tracks.residual_m,
            tracks.residual_valid,
            vehicles.profile,
            vehicles.lane,
            seen.heading_rad,
            seen.lane_poly,
            seen.camera_valid,
        )
        watch.lap("matching")
        self._detect(rows, tracks, vehicles, seen, threads, watch)
        filters = self._filters
        self._localization.step(filters, rows, tracks, vehicles, seen, self.answers.alarm, threads)
        self.answers.estimate_m[rows] = filters.mean[rows, :, :2]
        self.answers.isolated[rows] = filters.isolated[rows]
        watch.lap("localization")

    def _detect(
        self, rows: Ints, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads, watch: Stopwatch
    ) -> None:
        vehicle = tracks.vehicle[rows]
        profile = vehicles.profile[vehicle]
        observation = Observation(
            rows=rows,
            profile=profile,
            residual_m=tracks.residual_m[rows],
            valid=tracks.residual_valid[rows],
            scale_m=self._watchers.scale_m[profile],
            speed_mps=seen.speed_mps[vehicle],
            curvature_per_m=2.0 * seen.lane_poly[vehicle, 2],
            camera_sigma_m=seen.camera_sigma_m[vehicle],
            step_s=self._world.step_s,
        )
        attacked = tracks.attacked[rows]
        watch.lap("matching")
        for k, detector in enumerate(self._watchers.detectors):
            state = self._detector_states[k]
            if isinstance(detector, LabelledDetector):
                verdict = detector.update(attacked)
            elif state is not None:
                verdict = detector.update(state, observation, self._watchers.thresholds[profile, k], threads)
            self.answers.statistic[rows, k] = verdict.statistic
            self.answers.scored[rows, k] = verdict.scored
            self.answers.alarm[rows, k] = verdict.alarm
            watch.lap(f"detector {self._watchers.names[k]}")
