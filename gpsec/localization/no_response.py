"""No response: GNSS is trusted whatever the detector says."""

from typing import ClassVar

from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class NoResponse(Response):
    """The EKF goes on with GNSS; the lower bound of every table."""

    name: ClassVar[str] = "none"
    isolates: ClassVar[bool] = False

    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Do nothing."""
