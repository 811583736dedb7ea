"""What takes SUMO's place in a run: the part that all of them share."""

from types import TracebackType
from typing import Self

from gpsec.traffic.commands import Commands
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.zones import KeysOfTypes
from gpsec.types.drawn_zones import DrawnZone


class OfflineTraffic:
    """Traffic without a simulation; a subclass gives `step_s` and `frames` of a `gpsec.traffic.source.TrafficSource`.

    Attributes:
        options: what a simulation would be started with.
        sumo_s: 0, there is no simulation.
        read_s: wall-clock seconds spent in making frames so far.
        warnings: none.
        traffic_only: none.
    """

    def __init__(self, options: SumoOptions) -> None:
        self.options = options
        self.sumo_s = 0.0
        self.read_s = 0.0
        self.warnings: list[str] = []
        self.traffic_only: dict[str, int] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def zones(self, known_keys: KeysOfTypes) -> list[DrawnZone]:
        """Return none."""
        return []

    def command(self, commands: Commands) -> None:
        """Do nothing: what is recorded cannot react."""

    def close(self) -> None:
        """Do nothing: there are no resources."""
