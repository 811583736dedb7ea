"""Who of SUMO's vehicles is part of the fleet, in which row, and where."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Mapping, Set
from itertools import chain

import libsumo
import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.core.geo import yaw_from_sumo_angle
from gpsec.core.tables import Slots
from gpsec.traffic.names import VehicleNames
from gpsec.traffic.source import Departure, Equip
from gpsec.traffic.vehicle_attacks import NOWHERE_M, Spoofers
from gpsec.traffic.vehicletypes import VehicleType, read_type

# A move may be this much longer than the speed allows before it counts as a jump.
JUMP_MARGIN_M = 1.0
# Speed is only asked for where a move is this much longer than the last one.
SUSPECT_M = 0.5


class Roster:
    """The equipped vehicles of a running simulation.

    Each is in one of two places: on the road, where it owns a row, or away (teleporting, parked, on a lane that the
    map has not) until it is seen on the road again.

    Attributes:
        left: rows that were left in the last step.
        departures: vehicles that entered in the last step.
        spoofers: vehicles that carry one; never equipped.
        traffic_only: vehicles so far of each SUMO class that is never equipped.
    """

    def __init__(self, lane_index: Mapping[str, int], equip: Equip, spoofers: Spoofers, names: VehicleNames) -> None:
        self.spoofers = spoofers
        self._names = names
        self.traffic_only: Counter[str] = Counter()
        self.left: list[int] = []
        self.departures: list[Departure] = []
        self._lane_index = lane_index
        self._stretch = _Stretch(lane_index)
        self._equip = equip
        self._slots = Slots()
        self._types: dict[str, VehicleType] = {}
        self._row_of: dict[str, int] = {}
        self._away: dict[str, None] = {}  # a set that keeps its order
        self._equipped: set[str] = set()  # those in the simulation, on the road or away
        self._started = False
        # Who is on the road, in the order in which SUMO keeps its vehicles, since it finds the next one faster then;
        # where they are, and how far they came in the last step.
        self._ids: list[str] = []
        self._front_m: Floats = np.zeros((0, 2))
        self._moved_m: Floats = np.zeros(0)
        self._lane: Ints = np.zeros(0, np.int32)
        # Their rows, ascending, and where in `_ids` the vehicles of these are; made when it is needed.
        self._rows: Ints = np.zeros(0, np.int32)
        self._by_row: Longs | None = None

    @property
    def equipped(self) -> Set[str]:
        """SUMO's ids of the fleet, on the road or away."""
        return self._equipped

    def read(self, step_s: float) -> None:
        """Bring everything up to date with the simulation after a step of `step_s`."""
        self.left = []
        self.departures = []
        self._note_events()
        jumped = self._read_kept(step_s)
        for vehicle_id in (*jumped, *self._away, *self._departed()):
            self._try_to_enter(vehicle_id, step_s)

    def positions(self) -> tuple[Ints, Floats, Ints]:
        """Return rows (N,), ascending, front bumper (N, 2) and lane (N,) of those on the road, as new arrays."""
        if self._by_row is None:
            rows = np.array([self._row_of[name] for name in self._ids], np.int32)
            self._by_row = np.argsort(rows)
            self._rows = rows[self._by_row]
        return self._rows.copy(), self._front_m[self._by_row], self._lane[self._by_row]

    def _note_events(self) -> None:
        """Take off the road who arrived, began to teleport or to park."""
        simulation = libsumo.simulation
        for vehicle_id in simulation.getArrivedIDList():
            self.spoofers.forget(vehicle_id)
            if vehicle_id in self._equipped:
                self._forget(vehicle_id)
        for vehicle_id in simulation.getStartingTeleportIDList() + simulation.getParkingStartingVehiclesIDList():
            self._leave(vehicle_id)

    def _read_kept(self, step_s: float) -> list[str]:
        """Read who stayed on the road; return those who jumped, all who cannot go on having left."""
        front_m, lane = self._read_all()
        way_m = front_m - self._front_m
        moved_m = np.hypot(way_m[:, 0], way_m[:, 1])
        longer_m = moved_m - self._moved_m
        before = self._lane
        self._front_m, self._moved_m, self._lane = front_m, moved_m, lane
        if lane.min(initial=0) >= 0 and longer_m.max(initial=0.0) <= SUSPECT_M:
            return []
        on_map = _on_map(front_m, lane)
        doubtful = np.flatnonzero(~on_map | (longer_m > SUSPECT_M)).tolist()
        doubtful.sort(key=lambda at: self._row_of[self._ids[at]])
        jumped: list[str] = []
        for at, name in [(at, self._ids[at]) for at in doubtful]:
            if on_map[at]:
                if moved_m[at] <= self._reach_m(name, int(before[at]), step_s):
                    continue
                jumped.append(name)
            self._leave(name)
        for name in jumped:
            del self._away[name]
        return jumped

    def _reach_m(self, vehicle_id: str, lane_before: int, step_s: float) -> float:
        """Return how far a vehicle may have moved in the last step without a jump, by its speed before and after it."""
        vehicle = libsumo.vehicle
        speed_mps = vehicle.getSpeed(vehicle_id)
        before_mps = speed_mps - vehicle.getAcceleration(vehicle_id) * step_s
        stretch = max(1.0, self._stretch.at(lane_before), self._stretch.of(vehicle.getLaneID(vehicle_id)))
        return float(max(speed_mps, before_mps) * step_s * stretch + JUMP_MARGIN_M)

    def _read_all(self) -> tuple[Floats, Ints]:
        """Loop over the vehicles, the only such loop: plain getters, measured to be faster than subscriptions."""
        vehicle, index = libsumo.vehicle, self._lane_index
        try:
            places = list(map(vehicle.getPosition, self._ids))
        except libsumo.TraCIException:
            # Who is taken out by command is not reported as arrived.
            present = set(vehicle.getIDList())
            for name in [name for name in self._ids if name not in present]:
                self._forget(name)
            places = list(map(vehicle.getPosition, self._ids))
        count = len(places)
        return (
            np.fromiter(chain.from_iterable(places), np.float64, 2 * count).reshape(count, 2),
            np.array([index.get(lane_id, -1) for lane_id in map(vehicle.getLaneID, self._ids)], np.int32),
        )

    def _departed(self) -> Iterable[str]:
        """Yield the equipped among those who entered the network; at first also who was loaded with a state."""
        departed = libsumo.simulation.getDepartedIDList() if self._started else libsumo.vehicle.getIDList()
        self._started = True
        arrived = set(libsumo.simulation.getArrivedIDList())
        for vehicle_id in departed:
            if vehicle_id in arrived and vehicle_id not in libsumo.vehicle.getIDList():
                continue  # it has left already, and nobody else has come by its id
            if not self._equip_if_on_roads(vehicle_id):
                continue
            self._equipped.add(vehicle_id)
            yield vehicle_id

    def _equip_if_on_roads(self, vehicle_id: str) -> bool:
        type_id = libsumo.vehicle.getTypeID(vehicle_id)
        if self.spoofers.enter(vehicle_id, type_id):
            return False
        kind = self._type(type_id)
        if not kind.on_roads:
            self.traffic_only[kind.vehicle_class] += 1
            return False
        return self._equip(self._departure(vehicle_id, vehicle_id, -1))

    def _try_to_enter(self, vehicle_id: str, step_s: float) -> None:
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
        row = self._slots.take()
        self._row_of[vehicle_id] = row
        departure = self._departure(vehicle_id, self._names.give(vehicle_id), row)
        self.departures.append(departure)
        at = bisect_left(self._ids, vehicle_id)
        self._ids.insert(at, vehicle_id)
        self._front_m = np.insert(self._front_m, at, front_m, axis=0)
        self._moved_m = np.insert(self._moved_m, at, departure.speed_mps * step_s)
        self._lane = np.insert(self._lane, at, lane)
        self._by_row = None

    def _leave(self, vehicle_id: str) -> None:
        """Take `vehicle_id` off the road if it is there; it is away then."""
        row = self._row_of.pop(vehicle_id, -1)
        if row < 0:
            return
        at = bisect_left(self._ids, vehicle_id)
        del self._ids[at]
        self._front_m = np.delete(self._front_m, at, axis=0)
        self._moved_m = np.delete(self._moved_m, at)
        self._lane = np.delete(self._lane, at)
        self._by_row = None
        self._slots.give_back(row)
        self.left.append(row)
        self._away[vehicle_id] = None

    def _forget(self, vehicle_id: str) -> None:
        self._leave(vehicle_id)
        self._away.pop(vehicle_id, None)
        self._equipped.remove(vehicle_id)

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
            yaw_rad=yaw_from_sumo_angle(libsumo.vehicle.getAngle(vehicle_id)),
            speed_mps=libsumo.vehicle.getSpeed(vehicle_id),
            equipped_share=kind.equipped_share,
            sensors=kind.sensors,
            sumo_id=vehicle_id,
        )

    def _type(self, type_id: str) -> VehicleType:
        if type_id not in self._types:
            self._types[type_id] = read_type(type_id)
        return self._types[type_id]


class _Stretch:
    """How many metres of its shape a metre of a lane's length is: SUMO maps positions along the one onto the other."""

    def __init__(self, lane_index: Mapping[str, int]) -> None:
        self._index = lane_index
        self._names: list[str] = []
        self._known: dict[str, float] = {}

    def of(self, lane_id: str) -> float:
        """Return the length of a lane's shape over its length."""
        if lane_id not in self._known:
            shape = np.array(libsumo.lane.getShape(lane_id))[:, :2]
            length_m = libsumo.lane.getLength(lane_id)
            self._known[lane_id] = float(np.hypot(*np.diff(shape, axis=0).T).sum()) / length_m
        return self._known[lane_id]

    def at(self, lane: int) -> float:
        """Return the same of the lane with an index in the HD map."""
        if not self._names:
            self._names = [""] * (1 + max(self._index.values()))
            for name, index in self._index.items():
                self._names[index] = self._names[index] or name
        return self.of(self._names[lane])


def _on_map(front_m: Floats, lane: Ints) -> Flags:
    return np.asarray((front_m[:, 0] > NOWHERE_M) & (lane >= 0))
