"""What takes part in a run, and what is asked of it: traffic, and whoever looks on."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Protocol

from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.traffic.commands import Commands
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Equip, TrafficSource
from gpsec.traffic.zones import ZoneSource
from gpsec.types.vehicles import Identity


class Traffic(TrafficSource, ZoneSource, AbstractContextManager["Traffic"], Protocol):
    """What a run asks of its traffic.

    Attributes:
        warnings: of the simulation, once closed.

    """

    warnings: list[str]

    def command(self, commands: Commands) -> None:
        """Say what is to be done with vehicles after the last step, where they are steered."""
        ...

    @property
    def traffic_only(self) -> Mapping[str, int]:
        """Vehicles of each SUMO class that is never equipped, once the frames are over."""
        ...


# Starts the traffic: what SUMO is run with, index of each lane id, who is equipped.
StartTraffic = Callable[[SumoOptions, Mapping[str, int], Equip], Traffic]


class Onlooker(Protocol):
    """Whoever looks on while a scenario runs."""

    def begin(self, study: Study) -> None:
        """Learn what is compared, before the first step."""
        ...

    def see(self, view: StepView, outcomes: OutcomeState, fleet: Mapping[int, Identity]) -> None:
        """Look at a step, and at who each vehicle row stands for."""
        ...
