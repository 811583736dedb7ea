"""Traffic that is simulated once, and replayed in the place of SUMO as often as it is asked for."""

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from gpsec.core.errors import GpsecError
from gpsec.pipeline.build import drawn_zones, lay_ground
from gpsec.scenario import Scenario
from gpsec.traffic.commands import Commands
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.recording import RecordedTraffic, Recording, record_traffic
from gpsec.traffic.remote import RemoteSession
from gpsec.traffic.source import Equip
from gpsec.types.drawn_zones import MULTIPATH_ZONE, DrawnZone


class Replayed(RecordedTraffic):
    """Recorded traffic of a scenario in the place of its simulation; implements `gpsec.pipeline.interfaces.Traffic`.

    Attributes:
        options: what SUMO was run with.
        warnings: none, they were those of the simulation.
    """

    def __init__(self, recording: Recording, options: SumoOptions, zones: Sequence[DrawnZone]) -> None:
        super().__init__(recording)
        self.options = options
        self.warnings: list[str] = []
        self._zones = list(zones)

    @property
    def traffic_only(self) -> Mapping[str, int]:
        """Nothing: nobody but the fleet was recorded."""
        return {}

    def zones(self, known_keys: Any) -> list[DrawnZone]:
        """Return what is drawn, but for attack zones."""
        return self._zones

    def command(self, commands: Commands) -> None:
        """Refuse: a recording cannot react.

        Raises:
            GpsecError: always.
        """
        raise GpsecError("expected SUMO in closed loop, found a recording, which cannot react")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class Stage:
    """The traffic of one scenario and one seed of SUMO, simulated once."""

    def __init__(self, scenario: Scenario) -> None:
        """Simulate it.

        Raises:
            GpsecError: the scenario cannot be run.
        """
        ground = lay_ground(scenario)
        with RemoteSession(ground.options, ground.hd_map.lane_index, ground.choice.equipped) as session:
            self._zones = [zone for zone in drawn_zones(session) if zone.zone_type == MULTIPATH_ZONE]
            self._recording = record_traffic(session, scenario.duration_s)

    def start(self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> Replayed:
        """Return the traffic, for `gpsec.pipeline.run.run_scenario`."""
        return Replayed(self._recording, options, self._zones)
