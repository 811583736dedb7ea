"""Map matching (Eqs 2-6): which lane segment a position belongs to, and the signed offset from it.

Two ways of matching. *Tracked*: the nearest point on the chain of the lane that the camera follows (that lane, what
leads to it and on from it), as far as it leads the vehicle's way. *Nearest*, the paper's: the nearest point on any lane
whose direction differs by less than 60° (or by more than 120°) from the vehicle's heading.
"""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import LaneSides, MapArrays, MatchIndex, Pose
from gpsec.hdmap.search import MIN_COS, TRACKED, Ray, faces, is_on, match, match_tracked, project
from gpsec.types.vehicles import Vehicles


@inline
def offset_on(
    lanes: MapArrays, segment: int, x_m: float, y_m: float, heading_rad: float, extend: bool
) -> tuple[float, float]:
    """Return the offset d1 = d0 / cos(θ1 - θ2) from a segment (Eq 6), left positive, and the cosine.

    θ1 is the heading of the vehicle and θ2 the direction of the lane; against an oncoming lane the cosine is
    negative, so that left stays the vehicle's left. A cosine below `MIN_COS` in size means no match; the offset is
    then 0.
    """
    share, d2 = project(lanes, segment, x_m, y_m, extend)
    cross = lanes.dx[segment] * (y_m - lanes.y0_m[segment]) - lanes.dy[segment] * (x_m - lanes.x0_m[segment])
    d0 = sqrt(d2) if cross >= 0.0 else -sqrt(d2)
    held = min(max(share, 0.0), 1.0)
    cosine = cos(heading_rad - lanes.yaw0_rad[segment] - held * lanes.turn_rad[segment])
    if abs(cosine) < MIN_COS:
        return 0.0, cosine
    return d0 / cosine, cosine


@inline
def view_on(
    lanes: MapArrays, segment: int, x_m: float, y_m: float, heading_rad: float, extend: bool
) -> tuple[float, float]:
    """Return the offset, as `offset_on` does, from the arc over a segment, and the lane's direction minus the heading.

    The points of a map lie on the lane's centre. A segment between two of them is a chord, and the arc that turns as
    the lane does lies up to κ·L²/8 beside it: 0.26 m in a turn of 12 m radius with points every 5 m.
    """
    offset, cosine = offset_on(lanes, segment, x_m, y_m, heading_rad, extend)
    share, _ = project(lanes, segment, x_m, y_m, extend)
    held = min(max(share, 0.0), 1.0)
    turn = lanes.yaw0_rad[segment] + held * lanes.turn_rad[segment] - heading_rad
    if abs(cosine) < MIN_COS:
        return 0.0, turn
    bulge = 0.5 * lanes.turn_rad[segment] * lanes.length_m[segment] * held * (1.0 - held)
    return offset + bulge / cosine, turn


@kernel
def locate(rows: Ints, lanes: MapArrays, index: MatchIndex, sides: LaneSides, vehicles: Vehicles) -> None:
    """Place the rear axles of the vehicle rows `rows` on the true lanes: sets `segment` and what follows it.

    On a lane that leads against the vehicle, direction, offset and curvature are still those of the vehicle's way.
    """
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
        share, d2 = project(lanes, here, x, y, True)
        held = min(max(share, 0.0), 1.0)
        cross = lanes.dx[here] * (y - lanes.y0_m[here]) - lanes.dy[here] * (x - lanes.x0_m[here])
        yaw = lanes.yaw0_rad[here] + held * lanes.turn_rad[here]
        curvature = (1.0 - held) * lanes.curvature0_per_m[here] + held * lanes.curvature1_per_m[here]
        vehicles.segment[row] = here
        vehicles.against[row] = against
        vehicles.lane_offset_m[row] = way * (sqrt(d2) if cross >= 0.0 else -sqrt(d2))
        vehicles.lane_yaw_rad[row] = wrap_angle(yaw + pi) if against else yaw
        vehicles.curvature_per_m[row] = way * curvature
        vehicles.lane_width_m[row] = sides.width_m[lane]
        vehicles.marked[row] = not against and not sides.internal[lane] and not sides.internal[lanes.lane[here]]


class MatchedOffsets(NamedTuple):
    """Matches of n poses.

    Attributes:
        segment: (n,) -1 where there is none.
        offset_m: (n,) left positive, 0 where there is none.

    """

    segment: Ints
    offset_m: Floats


@kernel
def offsets(
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: int,
    lane: Ints,
    position_m: Floats,
    heading_rad: Floats,
    matches: MatchedOffsets,
) -> None:
    """Match (n, 2) positions with (n,) lanes and headings one by one, and fill `matches`."""
    for i in range(len(lane)):
        x, y = position_m[i, 0], position_m[i, 1]
        segment = match(lanes, index, mode, Pose(layer, lane[i], x, y, heading_rad[i]), -1)
        matches.segment[i] = segment
        matches.offset_m[i] = 0.0
        if segment >= 0:
            matches.offset_m[i], cosine = offset_on(lanes, segment, x, y, heading_rad[i], mode == TRACKED)
            if abs(cosine) < MIN_COS:
                matches.segment[i] = -1
