"""Who of SUMO's vehicles is part of the fleet, in which row, and where."""

from bisect import bisect_left
from collections.abc import Iterable, Mapping
from itertools import chain

import libsumo
import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.fleet import Slots
from gpsec.geo import yaw_from_sumo_angle
from gpsec.traffic.source import Departure, Equip
from gpsec.traffic.vehicletypes import VehicleType, read_type

# SUMO gives −2³⁰ where a vehicle is nowhere.
_NOWHERE_M = -1e9
# A move may be this much longer than the speed allows before it counts as a jump.
JUMP_MARGIN_M = 1.0


class Roster:
    """The equipped vehicles of a running simulation.

    Each is in one of two places: on the road, where it owns a row, or away (teleporting, parked, on a lane that the
    map has not) until it is seen on the road again.

    Attributes:
        rows: (N,) rows on the road, ascending.
        ids: SUMO's id of the vehicle in each of `rows`.
        left: rows that were left in the last step.
        departures: vehicles that entered in the last step.
    """

    def __init__(self, lane_index: Mapping[str, int], equip: Equip) -> None:
        self.rows: list[int] = []
        self.ids: list[str] = []
        self.left: list[int] = []
        self.departures: list[Departure] = []
        self._lane_index = lane_index
        self._equip = equip
        self._slots = Slots()
        self._types: dict[str, VehicleType] = {}
        self._row_of: dict[str, int] = {}
        self._away: dict[str, None] = {}  # a set that keeps its order
        # Lives that have begun, of the equipped vehicles that are in the simulation.
        self._lives: dict[str, int] = {}
        self._started = False
        # By row, after the last step.
        self._front_m: Floats = np.zeros((256, 2))
        self._speed_mps: Floats = np.zeros(256)
        self._lane: Ints = np.full(256, -1, np.int32)

    def read(self, step_s: float) -> None:
        """Bring everything up to date with the simulation after a step of `step_s`."""
        self.left = []
        self.departures = []
        self._note_events()
        jumped = self._read_kept(step_s)
        for vehicle_id in (*jumped, *self._away, *self._departed()):
            self._try_to_enter(vehicle_id)

    def positions(self) -> tuple[Ints, Floats, Floats, Ints]:
        """Return rows (N,), front bumper (N, 2), speed (N,) and lane (N,) of those on the road, as new arrays."""
        rows = np.array(self.rows, np.int32)
        return rows, self._front_m[rows], self._speed_mps[rows], self._lane[rows]

    def _note_events(self) -> None:
        """Take off the road who arrived, began to teleport or to park."""
        simulation = libsumo.simulation
        for vehicle_id in simulation.getArrivedIDList():
            if vehicle_id in self._lives:
                self._forget(vehicle_id)
        for vehicle_id in simulation.getStartingTeleportIDList() + simulation.getParkingStartingVehiclesIDList():
            self._leave(vehicle_id)

    def _read_kept(self, step_s: float) -> list[str]:
        """Read who stayed on the road; return those who jumped, all who cannot go on having left."""
        front_m, speed_mps, lane = self._read_all()
        rows = np.array(self.rows, np.int32)
        moved_m = np.hypot(*(front_m - self._front_m[rows]).T)
        reach_m = np.maximum(speed_mps, self._speed_mps[rows]) * step_s + JUMP_MARGIN_M
        on_map = _on_map(front_m, lane)
        jumped = on_map & (moved_m > reach_m)
        self._front_m[rows] = front_m
        self._speed_mps[rows] = speed_mps
        self._lane[rows] = lane
        names = [self.ids[at] for at in np.flatnonzero(jumped)]
        for vehicle_id in [self.ids[at] for at in np.flatnonzero(jumped | ~on_map)]:
            self._leave(vehicle_id)
        for vehicle_id in names:
            del self._away[vehicle_id]
        return names

    def _read_all(self) -> tuple[Floats, Floats, Ints]:
        """Loop over the vehicles, the only such loop: plain getters, measured to be faster than subscriptions."""
        vehicle = libsumo.vehicle
        position, speed, lane_id, index = vehicle.getPosition, vehicle.getSpeed, vehicle.getLaneID, self._lane_index
        try:
            places = [position(name) for name in self.ids]
        except libsumo.TraCIException:
            # Who is taken out by command is not reported as arrived.
            present = set(vehicle.getIDList())
            for name in [name for name in self.ids if name not in present]:
                self._forget(name)
            places = [position(name) for name in self.ids]
        count = len(places)
        return (
            np.fromiter(chain.from_iterable(places), np.float64, 2 * count).reshape(count, 2),
            np.array([speed(name) for name in self.ids], np.float64),
            np.array([index.get(lane_id(name), -1) for name in self.ids], np.int32),
        )

    def _departed(self) -> Iterable[str]:
        """Yield the equipped among those who entered the network; at first also who was loaded with a state."""
        departed = libsumo.simulation.getDepartedIDList() if self._started else libsumo.vehicle.getIDList()
        self._started = True
        arrived = set(libsumo.simulation.getArrivedIDList())
        for vehicle_id in departed:
            if vehicle_id in arrived or not self._equip_if_on_roads(vehicle_id):
                continue
            self._lives[vehicle_id] = 0
            yield vehicle_id

    def _equip_if_on_roads(self, vehicle_id: str) -> bool:
        kind = self._type(libsumo.vehicle.getTypeID(vehicle_id))
        return kind.on_roads and self._equip(self._departure(vehicle_id, vehicle_id, -1))

    def _try_to_enter(self, vehicle_id: str) -> None:
        """Give `vehicle_id` a row if it is where it can be followed."""
        vehicle = libsumo.vehicle
        try:
            front_m = np.array(vehicle.getPosition(vehicle_id))
        except libsumo.TraCIException:
            self._forget(vehicle_id)
            return
        lane = self._lane_index.get(vehicle.getLaneID(vehicle_id), -1)
        on_map = _on_map(front_m[None], np.array([lane]))[0]
        # SUMO gives a vehicle its lane back one step before it has left the parking area.
        if not on_map or vehicle.isStoppedParking(vehicle_id):
            self._away[vehicle_id] = None
            return
        self._away.pop(vehicle_id, None)
        self._lives[vehicle_id] += 1
        life = self._lives[vehicle_id]
        row = self._slots.take()
        self._make_room(row)
        at = bisect_left(self.rows, row)
        self.rows.insert(at, row)
        self.ids.insert(at, vehicle_id)
        self._row_of[vehicle_id] = row
        self._front_m[row] = front_m
        self._speed_mps[row] = vehicle.getSpeed(vehicle_id)
        self._lane[row] = lane
        name = vehicle_id if life == 1 else f"{vehicle_id}#{life}"
        self.departures.append(self._departure(vehicle_id, name, row))

    def _leave(self, vehicle_id: str) -> None:
        """Take `vehicle_id` off the road if it is there; it is away then."""
        row = self._row_of.pop(vehicle_id, -1)
        if row < 0:
            return
        at = bisect_left(self.rows, row)
        del self.rows[at], self.ids[at]
        self._slots.give_back(row)
        self.left.append(row)
        self._away[vehicle_id] = None

    def _forget(self, vehicle_id: str) -> None:
        self._leave(vehicle_id)
        self._away.pop(vehicle_id, None)
        del self._lives[vehicle_id]

    def _departure(self, vehicle_id: str, name: str, row: int) -> Departure:
        type_id = libsumo.vehicle.getTypeID(vehicle_id)
        kind = self._type(type_id)
        return Departure(
            row=row,
            vehicle_id=name,
            vehicle_type=type_id,
            vehicle_class=kind.vehicle_class,
            length_m=kind.length_m,
            width_m=kind.width_m,
            yaw_rad=float(yaw_from_sumo_angle(libsumo.vehicle.getAngle(vehicle_id))),
            equipped_share=kind.equipped_share,
            sensors=kind.sensors,
        )

    def _type(self, type_id: str) -> VehicleType:
        if type_id not in self._types:
            self._types[type_id] = read_type(type_id)
        return self._types[type_id]

    def _make_room(self, row: int) -> None:
        missing = row + 1 - len(self._speed_mps)
        if missing > 0:
            more = max(missing, len(self._speed_mps))
            self._front_m = np.concatenate([self._front_m, np.zeros((more, 2))])
            self._speed_mps = np.concatenate([self._speed_mps, np.zeros(more)])
            self._lane = np.concatenate([self._lane, np.full(more, -1, np.int32)])


def _on_map(front_m: Floats, lane: Ints) -> Flags:
    return np.asarray((front_m[:, 0] > _NOWHERE_M) & (lane >= 0))
