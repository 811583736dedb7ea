"""What every detector shares. A higher statistic is more anomalous, everywhere."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.fleet import Rows
from gpsec.threads import Threads


@dataclass(frozen=True)
class Observation:
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


@dataclass(frozen=True)
class Verdict:
    """A detector's answer for the m rows of an observation.

    Attributes:
        statistic: (m,) 0 where not scored.
        scored: (m,) the statistic is defined in this step (a valid residual, and warm-up is over).
        alarm: (m,) in alarm after this step; it is held where nothing was scored.
    """

    statistic: Floats
    scored: Flags
    alarm: Flags

    @classmethod
    def blank(cls, count: int) -> "Verdict":
        """Return a verdict on `count` rows to be filled in: nothing scored, no alarm."""
        return cls(np.zeros(count), np.zeros(count, np.bool_), np.zeros(count, np.bool_))


class Detector(ABC):
    """Frozen hyper-parameters and learned values; what changes is in the state."""

    name: ClassVar[str]

    @abstractmethod
    def new_state(self, capacity: int) -> Rows:
        """Return the detector's arrays for `capacity` rows."""

    @abstractmethod
    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Take one step: score the residuals against (m,) thresholds and update `state` at the observed rows.

        The result is the same for any `threads`; without, the caller's own is used.
        """


class LabelledDetector(ABC):
    """A bound of every table, not a detector: it is told the truth, and has no state."""

    name: ClassVar[str]

    @abstractmethod
    def update(self, attacked: Flags) -> Verdict:
        """Answer for m rows of which (m,) `attacked` are under attack in this step."""
