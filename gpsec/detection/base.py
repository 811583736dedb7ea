"""What every detector shares. A higher statistic is more anomalous, everywhere."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.channels import Channels
from gpsec.detection.monitor_state import MonitorRules
from gpsec.detection.pairing import Sampling
from gpsec.types.answers import Answers


class Observation(NamedTuple):
    """What a detector may know in one step: neither truth nor labels. m tracks, or m rows of anything else.

    Attributes:
        rows: (m,) rows of the detector's state and of the answers, each at most once.
        profile: (m,) index of the sensor profile among those that the detector was built for.
        residual_m: (m,) camera offset minus map-matched GNSS offset (0 where not valid).
        valid: (m,) both offsets are there.
        elapsed_steps: (m,) steps since the valid residual before this one, or since the row is in use.
        scale_m: (m,) standard deviation of the residual that the sensor profile promises on a straight road.
        speed_mps: (m,) odometer.
        curvature_per_m: (m,) of the lane as the camera sees it (2·C2), left positive.
        camera_sigma_m: (m,) standard deviation that the camera states.
        unmatched: (m,) the camera sees a lane, and no lane of the map that the vehicle may be on agrees (`Tracks`).
        channels: (m,) what the monitor says of the fix, where a detector of the run reads it.
        step_s: length of a step.
    """

    rows: Ints
    profile: Ints
    residual_m: Floats
    valid: Flags
    elapsed_steps: Ints
    scale_m: Floats
    speed_mps: Floats
    curvature_per_m: Floats
    camera_sigma_m: Floats
    unmatched: Flags
    channels: Channels
    step_s: float


class Detector(ABC):
    """Frozen hyper-parameters and learned values; what changes is in its state and in the answers.

    Attributes:
        name: in scenarios and tables.
        heeds_alarm: the state after a step depends on the alarm, or on the threshold. Until its first alarm since a
            fresh row or a gap, it must depend on neither: only then can operating points share it.
        reads_monitor: it reads `Observation.channels`, so that the monitor has to run.
        looks_back: it reads `Channels.separation`, for which four more filters have to run.
    """

    name: ClassVar[str]
    heeds_alarm: ClassVar[bool] = True
    reads_monitor: ClassVar[bool] = False
    looks_back: ClassVar[bool] = False

    @abstractmethod
    def new_state(self, capacity: int) -> Table[Any]:
        """Return what the detector remembers of `capacity` rows that have seen nothing."""

    @abstractmethod
    def update(
        self,
        state: Any,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        threads: Threads | None = None,
    ) -> None:
        """Take one step: score the residuals against (m,) thresholds.

        `state`, the structure of arrays of the detector's table, and column `column` of the `answers` change at the
        observed rows, and nowhere else. The result is the same for any `threads`; without, the caller's own is used.
        """


class LabelledDetector(ABC):
    """Not a detector: it is told the truth, and has no state."""

    name: ClassVar[str]

    @abstractmethod
    def update(self, rows: Ints, attacked: Flags, answers: Answers, column: int) -> None:
        """Answer for (m,) `rows` of which (m,) `attacked` are under attack in this step."""


@dataclass(frozen=True)
class Detection:
    """The detectors of a run, with what they need of its profiles.

    Attributes:
        names: of the K operating points, those of one detector side by side.
        rates: of each point, empty where its threshold is not calibrated.
        origins: of the threshold of each point: `counted`, `model` (of extreme values) or `fixed`.
        detectors: that of each point; points of one detector have the same object.
        thresholds: (profiles, K).
        scale_m: (profiles,) standard deviation of the residual that each profile promises.
        sampling: how old samples may be of which a residual is formed.
        monitor: what the monitor knows, if a detector reads it.
    """

    names: tuple[str, ...]
    rates: tuple[str, ...]
    origins: tuple[str, ...]
    detectors: tuple[Detector | LabelledDetector, ...]
    thresholds: Floats
    scale_m: Floats
    sampling: Sampling
    monitor: MonitorRules | None = None
