"""What every detector shares. A higher statistic is more anomalous, everywhere."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.threads import Threads
from gpsec.detection.alarm import GAP_S, HOLD_S, Alarms, AlarmState, steps_in

_ALONE = Threads(1)


class Observation(NamedTuple):
    """What a detector may know in one step: neither truth nor labels. m tracks, or m rows of anything else.

    Attributes:
        rows: (m,) rows of the detector's state, each at most once.
        profile: (m,) index of the sensor profile among those that the detector was built for.
        residual_m: (m,) camera offset minus map-matched GNSS offset (0 where not valid).
        valid: (m,) both offsets are there.
        scale_m: (m,) standard deviation of the residual that the sensor profile promises on a straight road.
        speed_mps: (m,) odometer.
        curvature_per_m: (m,) of the lane as the camera sees it (2·C2), left positive.
        camera_sigma_m: (m,) standard deviation that the camera states.
        step_s: length of a step.
    """

    rows: Ints
    profile: Ints
    residual_m: Floats
    valid: Flags
    scale_m: Floats
    speed_mps: Floats
    curvature_per_m: Floats
    camera_sigma_m: Floats
    step_s: float


class Verdict(NamedTuple):
    """Where a detector puts its answers: column `column` of arrays for M rows and K detectors.

    Attributes:
        statistic: (M, K) 0 where not scored.
        scored: (M, K) the statistic is defined in this step (a valid residual, and warm-up is over).
        alarm: (M, K) in alarm after this step; it is held where nothing was scored.
        column: that of the detector.
    """

    statistic: Floats
    scored: Flags
    alarm: Flags
    column: int

    @classmethod
    def blank(cls, capacity: int) -> "Verdict":
        """Return a place for the answers of one detector on `capacity` rows: nothing scored, no alarm."""
        shape = (capacity, 1)
        return cls(np.zeros(shape), np.zeros(shape, np.bool_), np.zeros(shape, np.bool_), 0)

    def at(self, rows: Ints) -> tuple[Floats, Flags, Flags]:
        """Return (m,) statistic, scored and alarm of `rows`."""
        return self.statistic[rows, self.column], self.scored[rows, self.column], self.alarm[rows, self.column]


class Detector(ABC):
    """Frozen hyper-parameters and learned values; what changes is in the state."""

    name: ClassVar[str]

    @abstractmethod
    def new_state(self, capacity: int) -> AlarmState:
        """Return the detector's arrays for `capacity` rows."""

    @abstractmethod
    def update(
        self,
        state: AlarmState,
        observation: Observation,
        threshold: Floats,
        verdict: Verdict,
        threads: Threads | None = None,
    ) -> None:
        """Take one step: score the residuals against (m,) thresholds; `state` and `verdict` change at observed rows.

        The result is the same for any `threads`; without, the caller's own is used.
        """


class KernelDetector(Detector):
    """A detector whose formula is a kernel.

    Attributes:
        kernel: ``kernel(part, seen, threshold, alarms, *arguments)`` updates the rows of the observation `seen` at the
            positions `part`.
    """

    kernel: ClassVar[Callable[..., None]]

    @abstractmethod
    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs of this detector: its parameters, and the arrays of its state."""

    def update(
        self,
        state: AlarmState,
        observation: Observation,
        threshold: Floats,
        verdict: Verdict,
        threads: Threads | None = None,
    ) -> None:
        """Hand the observation to the kernel."""
        alarms = Alarms(
            state.alarm,
            state.since_valid,
            state.since_scored,
            *verdict,
            gap_steps=steps_in(GAP_S, observation.step_s),
            hold_steps=steps_in(HOLD_S, observation.step_s),
        )
        positions = np.arange(len(observation.rows), dtype=np.int32)
        run = (_ALONE if threads is None else threads).run
        run(self.kernel, positions, observation, threshold, alarms, *self.arguments(state))


class LabelledDetector(ABC):
    """A bound of every table, not a detector: it is told the truth, and has no state."""

    name: ClassVar[str]

    @abstractmethod
    def update(self, rows: Ints, attacked: Flags, verdict: Verdict) -> None:
        """Answer for (m,) `rows` of which (m,) `attacked` are under attack in this step."""
