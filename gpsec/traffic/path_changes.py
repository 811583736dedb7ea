"""Where the path of a steered vehicle has to go over to the lane beside it, and whether there is room for that."""

import libsumo

from gpsec.traffic.shadows import KEPT_FREE_M

# Braking that a driver expects of those behind, and the time that they take to begin it.
_BRAKE_MPS2, _REACTION_S = 4.5, 0.5
_LEAST_GAP_M = 1.0
# Who is so near to the end of a lane, or to where SUMO stops it before that, that it could no longer come to stand
# comfortably before, does not get over any more.
_LATE_M, _LATE_S = 20.0, 1.0
# Bits of getNeighbors: leaders (not followers), and the right side (not the left).
_LEADERS, _RIGHT = 2, 1


def wanted_lanes(vehicle_id: str, path: str) -> int:
    """Return by how many lanes the route asks of the path, a lane's id, to go over to SUMO's left; negative: right."""
    for lane_id, _, _, offset, *_ in libsumo.vehicle.getBestLanes(vehicle_id):
        if lane_id == path:
            return int(offset)
    return 0


def beside(vehicle_id: str, side: int, reach_m: float) -> list[str]:
    """Return who is so near on one side, SUMO's left where `side` is above 0, that a vehicle may have to wait."""
    right = _RIGHT if side < 0 else 0
    near = [
        *libsumo.vehicle.getNeighbors(vehicle_id, right | _LEADERS),
        *libsumo.vehicle.getNeighbors(vehicle_id, right),
    ]
    return [name for name, gap_m in near if gap_m < reach_m]


def has_room(vehicle_id: str, side: int) -> bool:
    """Return whether nobody beside the vehicle would have to brake harder than one may expect."""
    vehicle = libsumo.vehicle
    own = vehicle.getSpeed(vehicle_id)
    right = _RIGHT if side < 0 else 0
    for name, gap_m in vehicle.getNeighbors(vehicle_id, right | _LEADERS):
        if gap_m < _needed_m(own, vehicle.getSpeed(name)):
            return False
    for name, gap_m in vehicle.getNeighbors(vehicle_id, right):
        if gap_m < _needed_m(vehicle.getSpeed(name), own):
            return False
    return True


def is_late(vehicle_id: str, ahead_m: float, lanes: int) -> bool:
    """Return whether a vehicle that has `ahead_m` left of its lane will not get over by `lanes`, see `wanted_lanes`."""
    own = libsumo.vehicle.getSpeed(vehicle_id)
    kept_free_m = KEPT_FREE_M if lanes > 1 else 0.0
    return bool(ahead_m < kept_free_m + _LATE_M + own * _LATE_S + own * own / (2.0 * _BRAKE_MPS2))


def take_another_way(vehicle_id: str, path: str) -> None:
    """Let a vehicle drive on where its path, a lane's id, leads, and from there by the fastest way to where it wants.

    SUMO would let it stand at the end of the lane until somebody let it in, which nobody does. Where no way leads on,
    or it has stops on its own, it keeps its route.
    """
    vehicle, simulation = libsumo.vehicle, libsumo.simulation
    if vehicle.getStops(vehicle_id, 1):
        return
    goal, kind = vehicle.getRoute(vehicle_id)[-1], vehicle.getTypeID(vehicle_id)
    onwards = sorted({link[0].rpartition("_")[0] for link in libsumo.lane.getLinks(path)})
    ways = [simulation.findRoute(edge, goal, kind) for edge in onwards]
    ways = [way for way in ways if way.edges]
    if ways:
        fastest = min(ways, key=lambda way: float(way.travelTime))
        vehicle.setRoute(vehicle_id, [path.rpartition("_")[0], *fastest.edges])


def _needed_m(behind_mps: float, ahead_mps: float) -> float:
    """Return the gap that the one behind needs to come down to the speed of the one ahead."""
    slower = max(0.0, behind_mps * behind_mps - ahead_mps * ahead_mps) / (2.0 * _BRAKE_MPS2)
    return float(_LEAST_GAP_M + _REACTION_S * max(0.0, behind_mps - ahead_mps) + slower)
