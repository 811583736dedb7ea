"""Where vehicles truly are on the map, and which lane their camera shows."""

from math import cos, exp, pi, sin, sqrt
from typing import NamedTuple

from gpsec.core.arrays import Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.core.noise import CAMERA_MISTAKE, uniform
from gpsec.hdmap.arrays import MapArrays, Roads
from gpsec.hdmap.search import Ray, faces, is_on, match_tracked, project
from gpsec.types.camera import LaneMistakes
from gpsec.types.vehicles import Vehicles


class OnRoad(NamedTuple):
    """A position beside a segment of the true map, in the direction of the lane.

    Attributes:
        offset_m: across the lane, left positive.
        yaw_rad: direction of the lane.
        curvature_per_m: of the lane, left positive.
    """

    offset_m: float
    yaw_rad: float
    curvature_per_m: float


@inline
def beside_segment(lanes: MapArrays, segment: int, x_m: float, y_m: float) -> OnRoad:
    """Return how a position lies beside a segment."""
    share, d2 = project(lanes, segment, x_m, y_m, True)
    held = min(max(share, 0.0), 1.0)
    cross = lanes.dx[segment] * (y_m - lanes.y0_m[segment]) - lanes.dy[segment] * (x_m - lanes.x0_m[segment])
    yaw = lanes.yaw0_rad[segment] + held * lanes.turn_rad[segment]
    curvature = (1.0 - held) * lanes.curvature0_per_m[segment] + held * lanes.curvature1_per_m[segment]
    return OnRoad(sqrt(d2) if cross >= 0.0 else -sqrt(d2), yaw, curvature)


@kernel
def locate(rows: Ints, step: int, step_s: float, roads: Roads, mistakes: LaneMistakes, vehicles: Vehicles) -> None:
    """Place the rear axles of the vehicle rows `rows` on the true lanes, and say what their cameras look at.

    On a lane that leads against the vehicle, directions, offsets and curvature are still those of the vehicle's way.
    `step` counts the camera's mistakes.
    """
    lanes, index, sides = roads.lanes, roads.lookup, roads.sides
    for row in rows:
        lane = vehicles.lane[row]
        x, y = vehicles.rear_m[row, 0], vehicles.rear_m[row, 1]
        ux, uy = cos(vehicles.yaw_rad[row]), sin(vehicles.yaw_rad[row])
        here = match_tracked(lanes, index, 0, lane, True, Ray(x, y, 0.0, 0.0), vehicles.segment[row])
        own = here
        if not is_on(lanes, 0, lane, here):
            own = match_tracked(lanes, index, 0, lane, False, Ray(x, y, 0.0, 0.0), -1)
        against = not faces(lanes, own, ux, uy)
        way = -1.0 if against else 1.0
        if faces(lanes, here, ux, uy) == against:
            here = match_tracked(lanes, index, 0, lane, True, Ray(x, y, way * ux, way * uy), -1)
        at = beside_segment(lanes, here, x, y)
        vehicles.segment[row] = here
        vehicles.against[row] = against
        vehicles.lane_offset_m[row] = way * at.offset_m
        vehicles.lane_yaw_rad[row] = wrap_angle(at.yaw_rad + pi) if against else at.yaw_rad
        vehicles.lane_width_m[row] = sides.width_m[lane]
        vehicles.followed_segment[row] = _followed(row, step_s, roads, mistakes, vehicles, Ray(x, y, ux, uy))
        shown = vehicles.followed_segment[row]
        if mistakes.wrong_per_h > 0.0:
            shown = _mistaken(row, step, step_s, roads, mistakes, vehicles)
        if shown != here:
            at = beside_segment(lanes, shown, x, y)
        seen = lanes.lane[shown]
        to_line_m = abs(0.5 * sides.width_m[seen] - abs(at.offset_m))
        vehicles.camera_lane[row] = lane if shown == here else seen
        vehicles.camera_offset_m[row] = way * at.offset_m
        vehicles.camera_yaw_rad[row] = wrap_angle(at.yaw_rad + pi) if against else at.yaw_rad
        vehicles.camera_curvature_per_m[row] = way * at.curvature_per_m
        marked = not against and not sides.internal[lane] and not sides.internal[seen]
        vehicles.marked[row] = marked and to_line_m >= mistakes.blind_m


@inline
def _followed(row: int, step_s: float, roads: Roads, mistakes: LaneMistakes, vehicles: Vehicles, ray: Ray) -> int:
    """Return the segment of the rear axle on the lane that the camera follows.

    SUMO changes a vehicle's lane with its front. The camera goes on with the chain of the lane before, until the rear
    axle is beyond its line.
    """
    lanes = roads.lanes
    lane, front = vehicles.lane[row], vehicles.segment[row]
    before = vehicles.followed[row]
    if before >= 0 and before != lane and not vehicles.against[row]:
        here = match_tracked(lanes, roads.lookup, 0, before, True, ray, vehicles.followed_segment[row])
        if here >= 0 and here != front:
            _, d2 = project(lanes, here, ray.x_m, ray.y_m, True)
            over_m = sqrt(d2) - 0.5 * roads.sides.width_m[lanes.lane[here]]
            if over_m > mistakes.hysteresis_m:
                vehicles.late_steps[row] += 1
            else:
                vehicles.late_steps[row] = 0
            if vehicles.late_steps[row] * step_s <= mistakes.late_s + 1e-9:
                vehicles.followed[row] = lanes.lane[here]
                return int(here)
    vehicles.followed[row] = lane
    vehicles.late_steps[row] = 0
    return int(front)


@inline
def _mistaken(row: int, step: int, step_s: float, roads: Roads, mistakes: LaneMistakes, vehicles: Vehicles) -> int:
    """Return the segment that the camera shows: that which it follows, or one of the lane beside it by mistake."""
    right = vehicles.followed_segment[row]
    lasts = int(mistakes.wrong_s / step_s + 0.5)
    left = vehicles.mistaken_steps[row]
    if left == 0:
        begins = 1.0 - exp(-mistakes.wrong_per_h * step_s / 3600.0)
        draw: float = uniform(vehicles.key[row], CAMERA_MISTAKE, step)
        if draw < begins:
            left = lasts if draw < 0.5 * begins else -lasts
    if left == 0:
        return int(right)
    vehicles.mistaken_steps[row] = left - 1 if left > 0 else left + 1
    lane = roads.lanes.lane[right]
    other = roads.graph.left[lane] if left > 0 else roads.graph.right[lane]
    if other < 0:
        return int(right)
    x, y, yaw = vehicles.rear_m[row, 0], vehicles.rear_m[row, 1], vehicles.yaw_rad[row]
    wrong = match_tracked(roads.lanes, roads.lookup, 0, other, False, Ray(x, y, cos(yaw), sin(yaw)), -1)
    return int(wrong) if wrong >= 0 else int(right)
