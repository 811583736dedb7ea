"""The way that a vehicle has before it, and who stands in it."""

from typing import NamedTuple

import libsumo
import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.geo import yaw_from_sumo_angle

_EVERY_M = 0.5  # between the points of a line
_MARGIN_M = 0.3  # between two bodies that pass each other


class StandingBody(NamedTuple):
    """A body on the road.

    Attributes:
        axis: (k,) points of its middle line, x + iy in metres.
        half_width_m: of it.
    """

    axis: Floats
    half_width_m: float


def body_of(name: str, front_m: tuple[float, float]) -> StandingBody:
    """Return the body of a vehicle with its front at `front_m`; it lies along its lane, since SUMO turns who stands."""
    vehicle = libsumo.vehicle
    yaw = yaw_from_sumo_angle(libsumo.lane.getAngle(vehicle.getLaneID(name), vehicle.getLanePosition(name)))
    front, length_m = complex(*front_m), vehicle.getLength(name)
    return StandingBody(_points([front, front - length_m * np.exp(1j * yaw)], length_m), 0.5 * vehicle.getWidth(name))


def way_of(name: str, reach_m: float) -> Floats:
    """Return (k,) points x + iy of the way of a vehicle from its front on, over the lanes that lead on its route."""
    vehicle, lanes = libsumo.vehicle, libsumo.lane
    lane, line = vehicle.getLaneID(name), [complex(*vehicle.getPosition(name))]
    edges = list(vehicle.getRoute(name)[vehicle.getRouteIndex(name) + 1 :])
    left_m = lanes.getLength(lane) - vehicle.getLanePosition(name)
    shape = _shape(lane)
    behind_m = abs(np.diff(shape))[::-1].cumsum()[::-1]  # from each point but the last to the end
    line += [point for point, to_end_m in zip(shape, [*behind_m, 0.0], strict=True) if to_end_m < left_m]
    while left_m < reach_m and (lane := next_lane(lane, edges)):
        line += _shape(lane)
        left_m += lanes.getLength(lane)
    return _points(line, reach_m)


def next_lane(lane: str, edges: list[str]) -> str:
    """Return the lane that leads on from one to the first of `edges`, which is taken from them; none: empty."""
    inside = lane.startswith(":")
    for onto, *_, via, _, _, _ in libsumo.lane.getLinks(lane):
        if inside or (edges and onto.rpartition("_")[0] == edges[0]):
            if not inside:
                edges.pop(0)
            return str(via or onto)
    return ""


def is_in_the_way(body: StandingBody, way: Floats, half_width_m: float) -> bool:
    """Return whether who goes `way` with a body of that width would touch the other one."""
    least_m = np.abs(body.axis[:, None] - way[None, :]).min()
    return bool(least_m < body.half_width_m + half_width_m + _MARGIN_M)


def _shape(lane: str) -> list[complex]:
    return [complex(*point[:2]) for point in libsumo.lane.getShape(lane)]


def _points(line: list[complex], reach_m: float) -> Floats:
    """Return points of a line at equal distances, at most `reach_m` from its beginning."""
    ends = np.array(line)
    at_m = np.concatenate([[0.0], np.abs(np.diff(ends)).cumsum()])
    points: Floats = np.interp(np.arange(0.0, min(reach_m, at_m[-1]) + 0.5 * _EVERY_M, _EVERY_M), at_m, ends)
    return points
