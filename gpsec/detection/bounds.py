"""The lower and the upper bound of every table."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.threads import Threads
from gpsec.detection.alarm import AlarmState
from gpsec.detection.base import Detector, LabelledDetector, Observation, Verdict


@dataclass(frozen=True)
class Never(Detector):
    """Never raises an alarm."""

    name: ClassVar[str] = "never"

    def new_state(self, capacity: int) -> AlarmState:
        """Return the state that every detector has."""
        return AlarmState.empty(capacity)

    def update(
        self,
        state: AlarmState,
        observation: Observation,
        threshold: Floats,
        verdict: Verdict,
        threads: Threads | None = None,
    ) -> None:
        """Score every valid residual with 0; no alarm, whatever the threshold."""
        at = observation.rows, verdict.column
        verdict.statistic[at] = 0.0
        verdict.scored[at] = observation.valid
        verdict.alarm[at] = False


@dataclass(frozen=True)
class Oracle(LabelledDetector):
    """Is in alarm exactly while the attack is active."""

    name: ClassVar[str] = "oracle"

    def update(self, rows: Ints, attacked: Flags, verdict: Verdict) -> None:
        """Score 1 under attack, else 0; every row is scored."""
        at = rows, verdict.column
        verdict.statistic[at] = attacked
        verdict.scored[at] = True
        verdict.alarm[at] = attacked
