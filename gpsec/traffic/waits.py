"""Why a vehicle stands: whom it waits for, and whether anybody at the end of that has a reason."""

from collections.abc import Callable

import libsumo
import numpy as np

from gpsec.traffic.path_changes import wanted_change, who_is_beside
from gpsec.traffic.ways import StandingBody, body_of, is_in_the_way, next_lane, way_of

HALTED_MPS = 0.1
# A leader, a stop line, a junction or one who is held still that is nearer is a reason to stand.
WAITING_GAP_M = 15.0
# Who has the right of way and comes to the junction within so long is waited for.
_COMES_S = 10.0


def is_stuck(name: str, is_held: Callable[[str], bool]) -> bool:
    """Return whether a vehicle that stands waits for nobody, or for others who wait for it, none with a reason.

    A reason is that one moves, is stopped, has a red light before it, or that `is_held` says so. Who waits for others
    who are stuck is not: they are.
    """
    waits, seen, circle = [name], {name}, False
    while waits:
        one = waits.pop()
        if _has_reason(one) or is_held(one):  # what is cheaper first
            return False
        awaited = _awaited(one)
        if one == name and not awaited:
            return True
        circle |= name in awaited
        waits += [other for other in awaited if other not in seen]
        seen.update(awaited)
    return circle


def _has_reason(name: str) -> bool:
    vehicle = libsumo.vehicle
    light = vehicle.getNextTLS(name)[:1]
    waits = any(distance_m < WAITING_GAP_M and state.lower() != "g" for _, _, distance_m, state in light)
    return bool(waits or vehicle.isStopped(name) or vehicle.getSpeed(name) >= HALTED_MPS)


def _awaited(name: str) -> list[str]:
    """Return who is before a vehicle, crosses before it or may, or is beside it where it has to go over."""
    vehicle = libsumo.vehicle
    leader = vehicle.getLeader(name, WAITING_GAP_M)  # may be one that is farther
    awaited = [leader[0]] if leader is not None and leader[0] and leader[1] < WAITING_GAP_M else []
    awaited += _in_the_junction(name)
    if side := wanted_change(name, vehicle.getLaneID(name)).lanes:
        awaited += who_is_beside(name, side, WAITING_GAP_M)
    return awaited


def _in_the_junction(name: str) -> list[str]:
    """Return for whom a vehicle waits that is right before a junction or within it.

    That is who is in it on a lane that crosses, and who comes to it with the right of way. SUMO's own list of foes is
    not used: it leaves out lanes that cross, nine of ten for a left turn in town, and in the middle of a junction it
    may be empty.
    """
    vehicle, lanes = libsumo.vehicle, libsumo.lane
    lane = vehicle.getLaneID(name)
    awaited = _crossing_within(name, lane) if lane.startswith(":") else []
    if lanes.getLength(lane) - vehicle.getLanePosition(name) > WAITING_GAP_M:
        return awaited
    onto = _next_lane_of(name, lane)
    if not onto.startswith(":"):
        return awaited
    crossed = lanes.getInternalFoes(onto)
    awaited += [other for foe in crossed for other in lanes.getLastStepVehicleIDs(foe) if other != name]
    for foe in set(lanes.getFoes(lane, onto)):
        awaited += [
            other
            for other in lanes.getLastStepVehicleIDs(foe)
            if _comes(other, foe) and _next_lane_of(other, foe) in crossed
        ]
    return awaited


def _crossing_within(name: str, lane: str) -> list[str]:
    """Return who is in a junction on a lane that crosses that of a vehicle, and is in its way or comes into it."""
    lanes = libsumo.lane
    others = [other for foe in lanes.getInternalFoes(lane) for other in lanes.getLastStepVehicleIDs(foe)]
    way, half_width_m = way_of(name, WAITING_GAP_M), 0.5 * libsumo.vehicle.getWidth(name)
    return [other for other in others if other != name and is_in_the_way(_swept(other), way, half_width_m)]


def _swept(name: str) -> StandingBody:
    """Return the body of a vehicle together with the way before it."""
    body = body_of(name, libsumo.vehicle.getPosition(name))
    return body._replace(axis=np.concatenate([body.axis, way_of(name, WAITING_GAP_M)]))


def _comes(name: str, lane: str) -> bool:
    """Return whether a vehicle is about to enter the junction at the end of its lane, and has no red light there."""
    vehicle = libsumo.vehicle
    ahead_m = libsumo.lane.getLength(lane) - vehicle.getLanePosition(name)
    if ahead_m > WAITING_GAP_M + _COMES_S * vehicle.getSpeed(name):
        return False
    light = vehicle.getNextTLS(name)[:1]
    return not any(distance_m < ahead_m + 1.0 and state in "ru" for _, _, distance_m, state in light)


def _next_lane_of(name: str, lane: str) -> str:
    """Return the lane onto which a vehicle leaves its own, `lane`; empty where there is none."""
    vehicle = libsumo.vehicle
    return next_lane(lane, list(vehicle.getRoute(name)[vehicle.getRouteIndex(name) + 1 :]))
