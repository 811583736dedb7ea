"""A log in the place of a simulation."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from gpsec.pipeline.build import Ground
from gpsec.pipeline.interfaces import StartTraffic
from gpsec.pipeline.loop_settings import Move
from gpsec.sensors.sense import Sensors


@dataclass(frozen=True)
class LoggedRun:
    """What a log has in the place of what is simulated.

    Attributes:
        start: its traffic.
        move: where its bodies are.
        sensors: gives its sensors for those of the profiles.
        notes: what the user should know of it.
    """

    start: StartTraffic
    move: Move
    sensors: Callable[[Sensors], Sensors]
    notes: tuple[str, ...] = ()

    def laid_on(self, ground: Ground) -> Ground:
        """Return what the run stands on."""
        return replace(ground, sensors=self.sensors(ground.sensors), move=self.move, notes=(*ground.notes, *self.notes))
