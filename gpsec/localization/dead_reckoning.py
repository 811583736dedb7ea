"""Dead reckoning: odometer and gyro alone while GNSS is isolated."""

from typing import ClassVar

from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class DeadReckoning(Response):
    """Nothing corrects the propagated estimate."""

    name: ClassVar[str] = "dead_reckoning"

    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Do nothing."""
