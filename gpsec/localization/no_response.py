"""No response: GNSS is trusted whatever the detector says."""

from typing import ClassVar

from gpsec.fleet import Measurements, Tracks, Vehicles
from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState


class NoResponse(Response):
    """The EKF goes on with GNSS; the lower bound of every table."""

    name: ClassVar[str] = "none"
    isolates: ClassVar[bool] = False

    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Do nothing."""
