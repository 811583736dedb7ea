"""What a running scenario reports of itself."""

from collections.abc import Callable
from dataclasses import dataclass

# Stages that end a scenario.
DONE, FAILED = "done", "failed"


@dataclass(frozen=True)
class Progress:
    """One report.

    Attributes:
        scenario: its name.
        time_s: simulated seconds done so far.
        duration_s: simulated seconds in all, None where the traffic ends by itself.
        vehicles: on the road now and part of the fleet.
        tracks: vehicle x plan pairs in use now.
        real_time_factor: simulated seconds a second of wall clock.
        stage: what is being done, such as ``loading the net``, ``running``, ``writing tables``.
        note: something that the user should know, shown once; empty for none.
    """

    scenario: str
    time_s: float = 0.0
    duration_s: float | None = None
    vehicles: int = 0
    tracks: int = 0
    real_time_factor: float = 0.0
    stage: str = "running"
    note: str = ""


Report = Callable[[Progress], None]
"""Is called with the progress of a scenario, several times a second."""
