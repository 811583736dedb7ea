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

from math import radians, sin
from typing import NamedTuple

import libsumo
import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, blank
from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.path_changes import side_to_change_to
from gpsec.traffic.sumo_lanes import SumoLanes

# Before a junction the shadow is back on its path from this far on, or from this long.
_ZONE_M, _ZONE_S = 30.0, 3.0
# The shadow moves no faster across the road: the roster takes longer moves for jumps.
_SHADOW_MPS = 2.0
# A path goes over to the lane beside it at the speed of SUMO's own vehicles, and at no larger angle than steering has:
# who stands does not slide across the road.
_PATH_MPS, MOST_HEADING_RAD = 0.9, radians(15.0)
# SUMO bounds the speed across the road of its own vehicles; those that are steered are put where they are to be.
_BOUND, _FREE_MPS, _NONE = "laneChangeModel.lcMaxSpeedLatStanding", "1", "0"
# Further from its path no shadow is put.
_REACH_M = 8.0
_NUDGE_M = 0.004
# In which steps it is looked whether a path leads on along the route.
_LOOK_EVERY_S = 1.0


class Held(NamedTuple):
    """Vehicles that are steered; N vehicle rows. What is across the road is as SUMO has it, see `SumoLanes`.

    Attributes:
        present: (N,) the row is that of a vehicle on the road.
        held: (N,) it is steered.
        path: (N,) lane that is its path.
        lane: (N,) lane on which SUMO had it before the last step.
        shift_m: (N,) of the path from the middle of that lane, while the path goes over to it.
        wish_m: (N,) displacement from the path that is commanded.
        shadow_m: (N,) where SUMO has the vehicle, from the middle of the path's lane.
        half_width_m: (N,) of its body.
        brake_mps2: (N,) for this step.
        position_m, speed_mps: (N,) along its lane, after the last step.
        mode: (N,) lane-change mode that it had before.
    """

    present: Flags = blank(False)
    held: Flags = blank(False)
    path: Ints = blank(-1)
    lane: Ints = blank(-1)
    shift_m: Floats = blank(0.0)
    wish_m: Floats = blank(0.0)
    shadow_m: Floats = blank(0.0)
    half_width_m: Floats = blank(0.9)
    brake_mps2: Floats = blank(0.0)
    position_m: Floats = blank(0.0)
    speed_mps: Floats = blank(0.0)
    mode: Ints = blank(0)


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
        self._steps = 0

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
        self._refresh()

    def name_of(self, row: int) -> str | None:
        """Return SUMO's id of the vehicle of a row, None where it has left."""
        return self._names.get(row)

    def take(self, commands: Commands, lane: Ints) -> None:
        """Take commands for vehicles of the fleet; `lane` (N,) is that of each vehicle row now."""
        held = self.now
        held.brake_mps2[:] = 0.0
        ours = ~commands.others & (commands.rows < self._held.capacity)
        ours[ours] = held.present[commands.rows[ours]]  # who has left since is passed over
        steered, released = ours & (commands.order == CommandKind.STEER), ours & (commands.order == CommandKind.RELEASE)
        rows = commands.rows[steered]
        for row in rows[~held.held[rows]].tolist():
            self._begin(row, int(lane[row]))
        held.wish_m[rows] = self.lanes.left_sign * commands.lateral_m[steered]
        for row in commands.rows[released].tolist():
            if held.held[row]:
                held.held[row] = False
                self._give_back(row)
        braking = steered | (ours & (commands.order == CommandKind.BRAKE))
        held.brake_mps2[commands.rows[braking]] = commands.brake_mps2[braking]
        self._refresh()

    def _begin(self, row: int, lane: int) -> None:
        """Take a vehicle from SUMO where it is: that is its path, which moves to the middle of the lane."""
        vehicle, name, held = libsumo.vehicle, self._names[row], self.now
        held.held[row] = True
        held.path[row] = held.lane[row] = lane
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

    def place(self, lane: Ints) -> None:
        """Put the shadows where they are to be in the next step, and brake; `lane` (N,) is that of each row now."""
        self._steps += 1
        if len(self.rows):
            self._put_shadows(self.rows, lane)
        held = self.now
        for row in np.flatnonzero(held.brake_mps2).tolist():
            libsumo.vehicle.setAcceleration(self._names[row], -float(held.brake_mps2[row]), self._step_s)

    def _put_shadows(self, rows: Ints, lane: Ints) -> None:
        held, lanes = self.now, self.lanes
        self._follow(rows, lane[rows])
        self._change_paths(rows)
        at, path = lane[rows], held.path[rows]
        slack_m = np.maximum(0.5 * lanes.width_m[path] - held.half_width_m[rows], 0.0)
        ahead_m = lanes.length_m[at] - held.position_m[rows]
        zone = lanes.internal[at] | (ahead_m < np.maximum(_ZONE_M, _ZONE_S * held.speed_mps[rows]))
        bound_m = np.where(zone, slack_m, _REACH_M)
        wanted_m = np.clip(held.shift_m[rows] + held.wish_m[rows], -bound_m, bound_m)
        most_m = _SHADOW_MPS * self._step_s
        held.shadow_m[rows] += np.clip(wanted_m - held.shadow_m[rows], -most_m, most_m)
        put_m = held.shadow_m[rows] + lanes.middle_m[path] - lanes.middle_m[at]
        # SUMO changes the lane of who moves out of it, and moves nobody out of the road.
        beside = np.where(put_m > 0.0, lanes.left[at], lanes.right[at]) >= 0
        nudge_m = np.where((put_m > 0.0) == beside, _NUDGE_M, -_NUDGE_M)
        vehicle = libsumo.vehicle
        names = [self._names[row] for row in rows.tolist()]
        for name, y, nudge in zip(names, (put_m - nudge_m).tolist(), nudge_m.tolist(), strict=True):
            vehicle.setLateralLanePosition(name, y)
            vehicle.changeSublane(name, nudge)

    def _follow(self, rows: Ints, lane: Ints) -> None:
        """Let paths lead on: onto the lane of a new edge on which SUMO has the vehicle, with its place across kept."""
        held, lanes = self.now, self.lanes
        new = lanes.edge[lane] != lanes.edge[held.path[rows]]
        if new.any():
            moved, path = rows[new], held.path[rows[new]]
            apart_m = lanes.middle_m[path] - lanes.middle_m[held.lane[moved]]
            held.shift_m[moved] += apart_m
            held.shadow_m[moved] += apart_m
            held.path[moved] = lane[new]
        held.lane[rows] = lane
        most_m = np.minimum(_PATH_MPS, sin(MOST_HEADING_RAD) * np.maximum(held.speed_mps[rows], 0.0)) * self._step_s
        held.shift_m[rows] -= np.clip(held.shift_m[rows], -most_m, most_m)

    def _change_paths(self, rows: Ints) -> None:
        """Let a path that does not lead on along the route go over to the lane beside it, where there is room."""
        held, lanes = self.now, self.lanes
        every = max(1, round(_LOOK_EVERY_S / self._step_s))
        due = ((rows + self._steps) % every == 0) & (np.abs(held.shift_m[rows]) < 1e-9)
        due &= ~lanes.internal[held.path[rows]]
        for row in rows[due].tolist():
            path = int(held.path[row])
            if lanes.left[path] < 0 and lanes.right[path] < 0:
                continue
            side = side_to_change_to(self._names[row], lanes.ids[path])
            to = int(lanes.left[path] if side > 0 else lanes.right[path]) if side else -1
            if to >= 0:
                apart_m = lanes.middle_m[to] - lanes.middle_m[path]
                held.path[row] = to
                held.shift_m[row] -= apart_m
                held.shadow_m[row] -= apart_m

    def settle(self, lane: Ints) -> Floats:
        """Read where SUMO has the vehicles after the step; return their (n,) surplus. `lane` (N,) is that of rows."""
        rows, held = self.rows, self.now
        if not len(rows):
            return np.zeros(0)
        names = [self._names[row] for row in rows.tolist()]
        position_m = np.array(list(map(libsumo.vehicle.getLanePosition, names)), np.float64)
        same = lane[rows] == held.lane[rows]
        way_m = position_m - held.position_m[rows]
        held.speed_mps[rows] = np.where(same, way_m / self._step_s, held.speed_mps[rows])
        held.position_m[rows] = position_m
        surplus_m: Floats = self.lanes.left_sign * (held.shift_m[rows] + held.wish_m[rows] - held.shadow_m[rows])
        return surplus_m

    def displaced(self, front_m: Floats, surplus_m: Floats, lane: Ints) -> Floats:
        """Return (n, 2) true positions of the steered vehicles, of SUMO's positions, their (n,) surplus and lanes."""
        true_m = front_m.copy()
        for k in np.flatnonzero(np.abs(surplus_m) > 1e-6).tolist():
            nx, ny = self.lanes.left_of(int(lane[k]), float(self.now.position_m[self.rows[k]]))
            true_m[k, 0] += surplus_m[k] * nx
            true_m[k, 1] += surplus_m[k] * ny
        return true_m
