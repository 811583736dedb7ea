"""What any source of traffic gives to the loop: libsumo, a recording, later a real log."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import ceil
from typing import Protocol

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.commands import Carried
from gpsec.traffic.names import first_life


@dataclass(frozen=True)
class Departure:
    """A vehicle that enters the fleet.

    Attributes:
        row: vehicle row that it owns until it leaves.
        vehicle_id: its name, of which there is one in a run: SUMO's id; a vehicle that teleported goes on as ``id#2``,
            ``id#3``, …, and so does one whose id was there before.
        vehicle_type: SUMO's vType id.
        vehicle_class: SUMO's vClass.
        length_m, width_m: of the body.
        yaw_rad: direction of the body at departure.
        speed_mps: SUMO's speed at departure.
        equipped_share: the type's ``gpsec.equipped`` (a probability), None where it has none.
        sensors: the type's ``gpsec.sensors`` (name of a sensor profile), None where it has none.
        sumo_id: SUMO's id, empty where it is not known.
    """

    row: int
    vehicle_id: str
    vehicle_type: str
    vehicle_class: str
    length_m: float
    width_m: float
    yaw_rad: float
    speed_mps: float
    equipped_share: float | None
    sensors: str | None
    sumo_id: str = ""

    @property
    def first_id(self) -> str:
        """SUMO's id, by which is drawn what all lives of a vehicle have in common."""
        return self.sumo_id or first_life(self.vehicle_id)


@dataclass(frozen=True)
class Frame:
    """One step of the traffic: the equipped vehicles that are on the road after it.

    Rows that are left are free before those that depart take theirs, so that one row may appear in both.

    Attributes:
        step: number of the step since the source began, from 0.
        time_s: simulated time after the step.
        left: rows of vehicles that arrived, teleported, parked or left the network.
        departures: vehicles that entered; each is also in `rows`.
        rows: (N,) vehicle rows on the road, ascending.
        front_m: (N, 2) centre of the front bumper in the net's frame.
        lane: (N,) index of the lane in the HD map.
        on_road: number of vehicles in the simulation, equipped or not.
        spoofers_m: name of a plan -> (n, 2) where those are that carry its spoofer.
        carried: how commands were carried out, None where the source takes none.
    """

    step: int
    time_s: float
    left: list[int]
    departures: list[Departure]
    rows: Ints
    front_m: Floats
    lane: Ints
    on_road: int
    spoofers_m: Mapping[str, Floats] = field(default_factory=dict)
    carried: Carried | None = None


# Decides whether a vehicle is part of the fleet; its row is not set yet (-1).
Equip = Callable[[Departure], bool]


class TrafficSource(Protocol):
    """Gives the truth of the traffic step by step.

    Attributes:
        sumo_s: wall-clock seconds spent in the simulation so far.
        read_s: wall-clock seconds spent reading it so far.
    """

    sumo_s: float
    read_s: float

    @property
    def step_s(self) -> float:
        """Length of a step."""
        ...

    def frames(self, duration_s: float | None) -> Iterator[Frame]:
        """Yield the steps until the traffic ends or, where given, after `duration_s` simulated seconds."""
        ...

    def close(self) -> None:
        """Let go of the simulation."""
        ...


def step_count(duration_s: float, step_s: float) -> int:
    """Return how many steps of `step_s` cover `duration_s`, at least 0; rounding errors do not add one."""
    return max(0, ceil(duration_s / step_s - 1e-6))
