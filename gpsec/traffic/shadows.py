"""Where the shadows of steered vehicles are to be in the next step, and how far from them the vehicles truly are.

The kernels of `gpsec.traffic.actuation`, which says what paths, shadows and surplus are.
"""

from math import cos, radians, sin
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import blank
from gpsec.traffic.commands import BRAKE, RELEASE, REMOVE, STEER
from gpsec.traffic.sumo_lanes import LaneArrays

# A path goes over to the lane beside it at the speed of SUMO's own vehicles, and at no larger angle than steering has:
# who stands does not slide across the road.
_PATH_MPS, MOST_HEADING_RAD = 0.9, radians(15.0)
_MOST_SLOPE = sin(MOST_HEADING_RAD)
# Before a junction the shadow is back on its path from this far on, or from this long. SUMO lets who would have to go
# over to the left by two lanes or more stand so far before the end of its lane: there the zone begins earlier.
_ZONE_M, _ZONE_S = 30.0, 3.0
KEPT_FREE_M = 40.0
# The shadow moves no faster across the road: the roster takes longer moves for jumps.
_SHADOW_MPS = 2.0
# Further from its path no shadow is put.
_REACH_M = 8.0
_NUDGE_M = 0.004
_NEVER = 2**31 - 1


class Held(NamedTuple):
    """Vehicles that are steered; N vehicle rows. What is across the road is as SUMO has it, see `sumo_lanes`.

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
        look_step: (N,) from which on it is looked whether the path leads on along the route.
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
    look_step: Ints = blank(0)


class Orders(NamedTuple):
    """The arrays of `gpsec.traffic.commands.Commands`."""

    rows: Ints
    others: Flags
    order: Ints
    lateral_m: Floats
    brake_mps2: Floats


class TakenOver(NamedTuple):
    """What orders change: begun, ended (n,) rows that are steered from now on and no longer.

    Attributes:
        sizes: (3,) how many begin, end, and how many orders there are for others, or to take somebody out.
    """

    begun: Ints
    ended: Ints
    sizes: Ints

    @classmethod
    def room(cls, size: int) -> "TakenOver":
        """Return room for as many commands."""
        return cls(np.zeros(size, np.int32), np.zeros(size, np.int32), np.zeros(3, np.int32))


class Placed(NamedTuple):
    """What SUMO is told of n vehicles, and where they are then.

    Attributes:
        put_m: (n,) lateral position on SUMO's lane, less the nudge; nudge_m: (n,) from there.
        surplus_m: (n,) how far to the left of the shadow the vehicle truly is.
        apart_m: (n, 2) the same as a vector.
    """

    put_m: Floats
    nudge_m: Floats
    surplus_m: Floats
    apart_m: Floats

    @classmethod
    def room(cls, size: int) -> "Placed":
        """Return room for so many vehicles."""
        return cls(np.zeros(size), np.zeros(size), np.zeros(size), np.zeros((size, 2)))


@kernel
def take_orders(orders: Orders, left_sign: float, held: Held, changes: TakenOver) -> None:
    """Take the orders for vehicles of the fleet that are on the road; the braking of the step before is over."""
    changes.sizes[:] = 0
    held.brake_mps2[:] = 0.0
    for k in range(len(orders.rows)):
        row, order = orders.rows[k], orders.order[k]
        changes.sizes[2] += orders.others[k] or order == REMOVE
        if orders.others[k] or row >= len(held.present) or not held.present[row]:
            continue
        if order == STEER:
            if not held.held[row]:
                changes.begun[changes.sizes[0]] = row
                changes.sizes[0] += 1
            held.wish_m[row] = left_sign * orders.lateral_m[k]
        elif order == RELEASE and held.held[row]:
            changes.ended[changes.sizes[1]] = row
            changes.sizes[1] += 1
        if order in (STEER, BRAKE):
            held.brake_mps2[row] = orders.brake_mps2[k]


@kernel
def move_shadows(rows: Ints, lane: Ints, lanes: LaneArrays, step_s: float, held: Held, placed: Placed) -> None:
    """Let paths lead on and shadows follow; `lane` (N,) is that of each vehicle row now.

    A path leads onto the lane of a new edge on which SUMO has the vehicle, with the place across the road kept.
    """
    for k in range(len(rows)):
        row = rows[k]
        at, path = lane[row], held.path[row]
        if lanes.edge[at] != lanes.edge[path]:
            apart_m = lanes.middle_m[path] - lanes.middle_m[held.lane[row]]
            held.shift_m[row] += apart_m
            held.shadow_m[row] += apart_m
            held.path[row] = path = at
            alone = lanes.internal[at] or (lanes.left[at] < 0 and lanes.right[at] < 0)
            held.look_step[row] = _NEVER if alone else 0
        held.lane[row] = at
        speed = max(held.speed_mps[row], 0.0)
        held.shift_m[row] -= _bounded(held.shift_m[row], min(_PATH_MPS, _MOST_SLOPE * speed) * step_s)
        slack_m = max(0.5 * lanes.width_m[path] - held.half_width_m[row], 0.0)
        ahead_m = lanes.length_m[at] - held.position_m[row]
        wanted_m = held.shift_m[row] + held.wish_m[row]
        zone_m = max(_ZONE_M, _ZONE_S * speed) + (
            KEPT_FREE_M if _may_be_two_to_the_right(wanted_m, path, lanes) else 0.0
        )
        wanted_m = _bounded(wanted_m, slack_m if lanes.internal[at] or ahead_m < zone_m else _REACH_M)
        held.shadow_m[row] += _bounded(wanted_m - held.shadow_m[row], _SHADOW_MPS * step_s)
        put_m = held.shadow_m[row] + lanes.middle_m[path] - lanes.middle_m[at]
        # SUMO changes the lane of who moves out of it, and moves nobody out of the road.
        beside = (lanes.left[at] if put_m > 0.0 else lanes.right[at]) >= 0
        nudge_m = _NUDGE_M if (put_m > 0.0) == beside else -_NUDGE_M
        placed.put_m[k], placed.nudge_m[k] = put_m - nudge_m, nudge_m


@kernel
def settle_shadows(
    rows: Ints, lane: Ints, position_m: Floats, lanes: LaneArrays, step_s: float, held: Held, placed: Placed
) -> None:
    """Take in where SUMO has the vehicles after the step, (n,) `position_m` along its lanes, and find the surplus."""
    for k in range(len(rows)):
        row = rows[k]
        if lane[row] == held.lane[row]:
            held.speed_mps[row] = (position_m[k] - held.position_m[row]) / step_s
        held.position_m[row] = position_m[k]
        surplus_m = lanes.left_sign[0] * (held.shift_m[row] + held.wish_m[row] - held.shadow_m[row])
        placed.surplus_m[k] = surplus_m
        placed.apart_m[k, 0] = placed.apart_m[k, 1] = 0.0
        if abs(surplus_m) > 1e-6:
            yaw = _course(lanes, lane[row], position_m[k])
            placed.apart_m[k, 0], placed.apart_m[k, 1] = -surplus_m * sin(yaw), surplus_m * cos(yaw)


@inline
def _bounded(value: float, most: float) -> float:
    return min(max(value, -most), most)


@inline
def _may_be_two_to_the_right(wanted_m: float, path: int, lanes: LaneArrays) -> bool:
    """Return whether a place is in a lane to SUMO's right of the path's, with two lanes or more to its own left."""
    beside = lanes.right[path]
    if beside < 0:
        return False
    if lanes.left[path] >= 0:
        return bool(wanted_m < -0.5 * lanes.width_m[path])
    line_m = lanes.middle_m[beside] - lanes.middle_m[path] - 0.5 * lanes.width_m[beside]
    return bool(lanes.right[beside] >= 0 and wanted_m < line_m)


@inline
def _course(lanes: LaneArrays, lane: int, position_m: float) -> float:
    """Return the direction of a lane at a position along it; it turns evenly between the points."""
    first, last = lanes.first[lane], lanes.first[lane + 1] - 1
    s = position_m * lanes.stretch[lane]
    k = first
    while k < last - 1 and lanes.at_m[k + 1] <= s:
        k += 1
    share = min(max((s - lanes.at_m[k]) / (lanes.at_m[k + 1] - lanes.at_m[k]), 0.0), 1.0)
    return float(lanes.yaw_rad[k] + share * (lanes.yaw_rad[k + 1] - lanes.yaw_rad[k]))
