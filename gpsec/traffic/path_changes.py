"""Where the path of a steered vehicle has to go over to the lane beside it, and whether there is room for that."""

from math import inf
from typing import NamedTuple

import libsumo

from gpsec.traffic.shadows import KEPT_FREE_M

# Braking that a driver expects of those behind, and the time that they take to begin it.
_BRAKE_MPS2, _REACTION_S = 4.5, 0.5
_LEAST_GAP_M = 1.0
# Who has to go over within so long falls back behind those beside it, where these drive and do not crawl: so much
# slower than they are, and so gently.
_SOON_S, _CRAWL_MPS, _SLOWER_MPS, _FALL_BACK_MPS2 = 20.0, 6.0, 3.0, 1.0
# Who is so near to the end of a lane, or to where SUMO stops it before that, that it could no longer come to stand
# comfortably before, does not get over any more.
_LATE_M, _LATE_S = 20.0, 1.0
# Bits of getNeighbors: leaders (not followers), and the right side (not the left).
_LEADERS, _RIGHT = 2, 1


class WantedChange(NamedTuple):
    """What the route asks of a path: to go over by `lanes` to SUMO's left (negative: right) within `ahead_m`."""

    lanes: int
    ahead_m: float


def wanted_change(vehicle_id: str, path: str) -> WantedChange:
    """Return what the route asks of the path of a vehicle, a lane's id."""
    for lane_id, length_m, _, offset, *_ in libsumo.vehicle.getBestLanes(vehicle_id):
        if lane_id == path:
            return WantedChange(int(offset), float(length_m - libsumo.vehicle.getLanePosition(vehicle_id)))
    return WantedChange(0, 0.0)


def who_is_beside(vehicle_id: str, side: int, reach_m: float) -> list[str]:
    """Return who is so near on one side, SUMO's left where `side` is above 0, that a vehicle may have to wait."""
    right = _RIGHT if side < 0 else 0
    near = [
        *libsumo.vehicle.getNeighbors(vehicle_id, right | _LEADERS),
        *libsumo.vehicle.getNeighbors(vehicle_id, right),
    ]
    return [name for name, gap_m in near if gap_m < reach_m]


class RoomBeside(NamedTuple):
    """Whether nobody beside a vehicle would have to brake harder than one may expect.

    Attributes:
        enough: there is room.
        beside_mps: speed of the slowest of those that drive abreast or are too near ahead, infinite without any.
    """

    enough: bool
    beside_mps: float


def room_beside(vehicle_id: str, side: int) -> RoomBeside:
    """Return what room there is on a side, 1 for SUMO's left and -1 for its right."""
    vehicle = libsumo.vehicle
    own = vehicle.getSpeed(vehicle_id)
    right = _RIGHT if side < 0 else 0
    enough, beside_mps = True, inf
    for name, gap_m in vehicle.getNeighbors(vehicle_id, right | _LEADERS):
        other = vehicle.getSpeed(name)
        if gap_m < _needed_m(own, other):
            enough, beside_mps = False, min(beside_mps, other)
    for name, gap_m in vehicle.getNeighbors(vehicle_id, right):
        other = vehicle.getSpeed(name)
        if gap_m < _needed_m(other, own):
            enough = False
            if gap_m < _LEAST_GAP_M:
                beside_mps = min(beside_mps, other)
    return RoomBeside(enough, beside_mps)


def fall_back(vehicle_id: str, room: RoomBeside, wanted: WantedChange, lasts_s: float) -> None:
    """Let a vehicle that has to go over soon slow down behind those beside it, gently, for `lasts_s` seconds.

    At their speed it would drive abreast of them to the end of its lane, and stand there.
    """
    own = libsumo.vehicle.getSpeed(vehicle_id)
    if wanted.ahead_m < _SOON_S * own and _CRAWL_MPS < room.beside_mps < own + _SLOWER_MPS:
        libsumo.vehicle.setAcceleration(vehicle_id, -_FALL_BACK_MPS2, lasts_s)


def is_late(vehicle_id: str, ahead_m: float, lanes: int) -> bool:
    """Return whether a vehicle that has `ahead_m` left of its lane will not get over by `lanes`, see `WantedChange`."""
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
