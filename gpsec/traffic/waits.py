"""Why a vehicle stands: whom it waits for, and whether anybody at the end of that has a reason."""

from collections.abc import Callable

import libsumo

from gpsec.traffic.path_changes import wanted_change, who_is_beside
from gpsec.traffic.ways import next_lane

HALTED_MPS = 0.1
# A leader, a stop line, a junction or one who is held still that is nearer is a reason to stand.
WAITING_GAP_M = 15.0


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
    leader = vehicle.getLeader(name, WAITING_GAP_M)
    awaited = [leader[0]] if leader is not None and leader[0] else []
    awaited += [foe for foe, *_, must, _ in vehicle.getJunctionFoes(name, WAITING_GAP_M) if must]
    awaited += _crossing(name)
    if side := wanted_change(name, vehicle.getLaneID(name)).lanes:
        awaited += who_is_beside(name, side, WAITING_GAP_M)
    return awaited


def _crossing(name: str) -> list[str]:
    """Return who is in a junction on a lane that crosses the way of a vehicle that is right before it, or within it.

    SUMO's list of foes knows those that come to a junction, and is empty for who waits in the middle of one.
    """
    vehicle, lanes = libsumo.vehicle, libsumo.lane
    lane = vehicle.getLaneID(name)
    if lanes.getLength(lane) - vehicle.getLanePosition(name) > WAITING_GAP_M:
        return []
    edges = list(vehicle.getRoute(name)[vehicle.getRouteIndex(name) + 1 :])
    onto = next_lane(lane, edges)
    crossed = lanes.getInternalFoes(onto) if onto.startswith(":") else ()
    return [other for foe in crossed for other in lanes.getLastStepVehicleIDs(foe) if other != name]
