"""Carries out commands under libsumo: vehicles that are steered from outside, in traffic that sees and follows them.

A steered vehicle has a **path**, the middle of a lane that leads on along its route. Its true place across the road is
that of the path and the displacement that is commanded. SUMO holds a **shadow** of it: the same place, but where SUMO
could not go on from there. A vehicle that sticks out of its lane stops for ever at the end of a junction, and one on a
lane that does not lead on stops at its end; so from some way before a junction to its end the shadow keeps to the lane
of the path. The rest is the **surplus**, which is added to the position.

Each step, for each vehicle, in lane-change mode 0: ``setLateralLanePosition(id, y - e)`` and ``changeSublane(id, e)``,
with e = 4 mm towards the lane beside, or away from the edge of the road. SUMO keeps speed, leaders, signals and route;
followers see the vehicle where it is; SUMO changes its lane by itself.
"""

from collections import deque
from collections.abc import Callable

import libsumo
import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import Table
from gpsec.traffic.commands import Commands
from gpsec.traffic.path_changes import fall_back, is_late, room_beside, take_another_way, wanted_change
from gpsec.traffic.shadows import Held, Orders, Placed, TakenOver, move_shadows, settle_shadows, take_orders
from gpsec.traffic.sumo_lanes import SumoLanes

# SUMO bounds the speed across the road of its own vehicles; those that are steered are put where they are to be.
_BOUND, _FREE_MPS, _NONE = "laneChangeModel.lcMaxSpeedLatStanding", "1", "0"
# So often it is looked whether a path leads on along the route, which may change; and whether there is room to go over.
_LOOK_S, _LOOK_FOR_ROOM_S = 5.0, 0.2


class Actuation:
    """The steered vehicles of a simulation.

    Attributes:
        lanes: of the net.
        rows: (n,) vehicle rows that are steered, ascending.
    """

    def __init__(self, lanes: SumoLanes, step_s: float) -> None:
        self.lanes = lanes
        self.rows: Ints = np.zeros(0, np.int32)
        self._step_s = step_s
        self._held = Table(Held)
        self._names: dict[int, str] = {}
        self._steered: list[str] = []  # SUMO's ids of `rows`
        self._changes, self._placed = TakenOver.room(0), Placed.room(0)
        self._steps = 0
        self._load()

    def _load(self) -> None:
        """Call the kernels for nobody: their machine code is loaded while nothing is timed."""
        nobody: Ints = np.zeros(0, np.int32)
        self.take(Commands.none(), nobody)
        move_shadows(nobody, nobody, self.lanes.now, self._step_s, self.now, self._placed)
        settle_shadows(nobody, nobody, np.zeros(0), self.lanes.now, self._step_s, self.now, self._placed)

    @property
    def now(self) -> Held:
        """The vehicles as they are held."""
        return self._held.now

    def enter(self, row: int, sumo_id: str, width_m: float) -> None:
        """Let a vehicle that has departed have a row."""
        self._held.grow(row + 1 if row < self._held.capacity else 2 * (row + 1))
        self._held.reset(np.array([row], np.int32))
        self.now.present[row] = True
        self.now.half_width_m[row] = 0.5 * width_m
        self._names[row] = sumo_id

    def leave(self, rows: list[int]) -> None:
        """Forget the vehicles of `rows`, which may still be in the simulation."""
        for row in rows:
            if self.now.held[row] and self._names[row] in libsumo.vehicle.getIDList():
                self._give_back(row)
            self.now.held[row] = self.now.present[row] = False
            self.now.brake_mps2[row] = 0.0
            del self._names[row]
        if rows:
            self._refresh()

    def let_go(self, row: int) -> None:
        """Command the vehicle of a row no more: SUMO is about to take it out."""
        self.now.held[row] = self.now.present[row] = False
        self.now.brake_mps2[row] = 0.0
        self._refresh()

    def name_of(self, row: int) -> str | None:
        """Return SUMO's id of the vehicle of a row, None where it has left."""
        return self._names.get(row)

    def take(self, commands: Commands, lane: Ints) -> bool:
        """Take commands for vehicles of the fleet; `lane` (N,) is that of each vehicle row now.

        Return whether there are others: for those who are not part of it, or to take somebody out.
        """
        orders = Orders(commands.rows, commands.others, commands.order, commands.lateral_m, commands.brake_mps2)
        if len(orders.rows) > len(self._changes.begun):
            self._changes = TakenOver.room(2 * len(orders.rows))
        changes = self._changes
        take_orders(orders, float(self.lanes.now.left_sign[0]), self.now, changes)
        begun, ended, others = changes.sizes.tolist()
        for row in changes.begun[:begun].tolist():
            self._begin(row, int(lane[row]))
        for row in changes.ended[:ended].tolist():
            self.now.held[row] = False
            self._give_back(row)
        if begun or ended:
            self._refresh()
        return bool(others)

    def _begin(self, row: int, lane: int) -> None:
        """Take a vehicle from SUMO where it is: that is its path, which moves to the middle of the lane."""
        vehicle, name, held = libsumo.vehicle, self._names[row], self.now
        held.held[row] = True
        held.path[row] = held.lane[row] = lane
        held.look_step[row] = self._steps + round(_LOOK_FOR_ROOM_S / self._step_s)
        held.shift_m[row] = held.shadow_m[row] = vehicle.getLateralLanePosition(name)
        held.position_m[row], held.speed_mps[row] = vehicle.getLanePosition(name), vehicle.getSpeed(name)
        held.mode[row] = vehicle.getLaneChangeMode(name)
        vehicle.setLaneChangeMode(name, 0)
        vehicle.setParameter(name, _BOUND, _FREE_MPS)

    def _give_back(self, row: int) -> None:
        """Let SUMO choose the lane of a vehicle again."""
        libsumo.vehicle.setLaneChangeMode(self._names[row], int(self.now.mode[row]))
        libsumo.vehicle.setParameter(self._names[row], _BOUND, _NONE)

    def _refresh(self) -> None:
        self.rows = np.flatnonzero(self.now.held).astype(np.int32)
        self._steered = [self._names[row] for row in self.rows.tolist()]
        if len(self.rows) > len(self._placed.put_m):
            self._placed = Placed.room(2 * len(self.rows))

    def place(self, lane: Ints) -> None:
        """Put the shadows where they are to be in the next step, and brake; `lane` (N,) is that of each row now."""
        self._steps += 1
        count = len(self.rows)
        if count:
            self._change_paths(lane)
            placed, vehicle = self._placed, libsumo.vehicle
            move_shadows(self.rows, lane, self.lanes.now, self._step_s, self.now, placed)
            _call(vehicle.setLateralLanePosition, self._steered, placed.put_m[:count].tolist())
            _call(vehicle.changeSublane, self._steered, placed.nudge_m[:count].tolist())
        brake_mps2 = self.now.brake_mps2
        for row in np.flatnonzero(brake_mps2).tolist():
            libsumo.vehicle.setAcceleration(self._names[row], -float(brake_mps2[row]), self._step_s)

    def _change_paths(self, lane: Ints) -> None:
        """Let a path that does not lead on along the route go over to the lane beside it, where there is room."""
        held = self.now
        for row in self.rows[held.look_step[self.rows] <= self._steps].tolist():
            if self.lanes.now.edge[lane[row]] == self.lanes.now.edge[held.path[row]] and held.shift_m[row] == 0.0:
                held.look_step[row] = self._steps + round(self._change_path(row) / self._step_s)

    def _change_path(self, row: int) -> float:
        """Let a path go over where it has to and can; return the seconds after which to look again."""
        held, lanes, name = self.now, self.lanes.now, self._names[row]
        path = int(held.path[row])
        if lanes.internal[path] or (lanes.left[path] < 0 and lanes.right[path] < 0):
            return _LOOK_S
        wanted = wanted_change(name, self.lanes.ids[path])
        side = (wanted.lanes > 0) - (wanted.lanes < 0)
        to = int(lanes.left[path] if side > 0 else lanes.right[path]) if side else -1
        if to < 0:
            return _LOOK_S
        room = room_beside(name, side)
        if not room.enough:
            if is_late(name, float(lanes.length_m[path] - held.position_m[row]), wanted.lanes):
                take_another_way(name, self.lanes.ids[path])
            else:
                fall_back(name, room, wanted, _LOOK_FOR_ROOM_S)
            return _LOOK_FOR_ROOM_S
        apart_m = lanes.middle_m[to] - lanes.middle_m[path]
        held.path[row] = to
        held.shift_m[row] -= apart_m
        held.shadow_m[row] -= apart_m
        return 0.0

    def settle(self, lane: Ints) -> tuple[Floats, Floats]:
        """Read where SUMO has the vehicles after the step; `lane` (N,) is that of each row.

        Return their surplus as (n,) metres to the left and (n, 2) vectors, to be added to SUMO's positions.
        """
        count, placed = len(self.rows), self._placed
        if count:
            position_m = np.array(list(map(libsumo.vehicle.getLanePosition, self._steered)), np.float64)
            settle_shadows(self.rows, lane, position_m, self.lanes.now, self._step_s, self.now, placed)
        return placed.surplus_m[:count].copy(), placed.apart_m[:count]


def _call(command: Callable[[str, float], None], names: list[str], values: list[float]) -> None:
    """Give the command for each vehicle; no loop of Python's own."""
    deque(map(command, names, values), maxlen=0)
