"""What frames every table: no alarm at all, and one that is told at once."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detector, LabelledDetector, Observation
from gpsec.types.answers import Answers


class Stateless(NamedTuple):
    """Nothing."""


@dataclass(frozen=True)
class Never(Detector):
    """Never raises an alarm."""

    name: ClassVar[str] = "never"
    heeds_alarm: ClassVar[bool] = False

    def new_state(self, capacity: int) -> Table[Stateless]:
        """Return a table that remembers nothing."""
        return Table(Stateless, capacity)

    def update(
        self,
        state: Any,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        threads: Threads | None = None,
    ) -> None:
        """Score every valid residual with 0; no alarm, whatever the threshold."""
        at = seen.rows, column
        answers.statistic[at] = 0.0
        answers.scored[at] = seen.valid
        answers.alarm[at] = False


@dataclass(frozen=True)
class Told(LabelledDetector):
    """Is in alarm exactly while the attack is active.

    It is no upper bound: isolating at once costs the drift of the odometer from the first second on, which becomes
    cross-track error in the next turn, where a later alarm has kept an error along the lane that was smaller.
    """

    name: ClassVar[str] = "told"

    def update(self, rows: Ints, attacked: Flags, answers: Answers, column: int) -> None:
        """Score 1 under attack, else 0; every row is scored."""
        at = rows, column
        answers.statistic[at] = attacked
        answers.scored[at] = True
        answers.alarm[at] = attacked
