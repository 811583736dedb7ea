"""The lower and the upper bound of every table."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.arrays import Flags, Floats
from gpsec.detection.alarm import AlarmState
from gpsec.detection.base import Detector, LabelledDetector, Observation, Verdict
from gpsec.fleet import Rows
from gpsec.threads import Threads


@dataclass(frozen=True)
class Never(Detector):
    """Never raises an alarm."""

    name: ClassVar[str] = "never"

    def new_state(self, capacity: int) -> AlarmState:
        """Return the state that every detector has."""
        return AlarmState.empty(capacity)

    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Score every valid residual with 0; no alarm, whatever the threshold."""
        verdict = Verdict.blank(len(observation.rows))
        verdict.scored[:] = observation.valid
        return verdict


@dataclass(frozen=True)
class Oracle(LabelledDetector):
    """Is in alarm exactly while the attack is active."""

    name: ClassVar[str] = "oracle"

    def update(self, attacked: Flags) -> Verdict:
        """Score 1 under attack, else 0; every row is scored."""
        verdict = Verdict.blank(len(attacked))
        verdict.statistic[:] = attacked
        verdict.scored[:] = True
        verdict.alarm[:] = attacked
        return verdict
