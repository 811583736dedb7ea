"""Map matching (Eqs 2-6): which lane segment a position belongs to, and the signed offset from it.

Two ways of matching. *Tracked*: the nearest point on the chain of the lane that the camera follows (that lane, what
leads to it and on from it), as far as it leads the vehicle's way. *Nearest*, the paper's: the nearest point on any lane
whose direction differs by less than 60° (or by more than 120°) from the vehicle's heading.
"""

from math import cos, pi, sin, sqrt

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import LaneSides, MapArrays, MatchIndex
from gpsec.hdmap.search import MIN_COS, TRACKED, faces, is_on, match, match_tracked, project


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
def locate(
    rows: Ints,
    lanes: MapArrays,
    index: MatchIndex,
    sides: LaneSides,
    lane: Ints,
    rear_m: Floats,
    yaw_rad: Floats,
    segment: Ints,
    against: Flags,
    lane_offset_m: Floats,
    lane_yaw_rad: Floats,
    curvature_per_m: Floats,
    lane_width_m: Floats,
    marked: Flags,
) -> None:
    """Place the rear axles of the vehicle rows `rows` on the true lanes; the arguments are fields of `Vehicles`.

    On a lane that leads against the vehicle, direction, offset and curvature are still those of the vehicle's way.
    """
    for row in rows:
        x = rear_m[row, 0]
        y = rear_m[row, 1]
        ux = cos(yaw_rad[row])
        uy = sin(yaw_rad[row])
        here = match_tracked(lanes, index, 0, lane[row], True, x, y, 0.0, 0.0, segment[row])
        own = here
        if not is_on(lanes, 0, lane[row], here):
            own = match_tracked(lanes, index, 0, lane[row], False, x, y, 0.0, 0.0, -1)
        against[row] = not faces(lanes, own, ux, uy)
        way = -1.0 if against[row] else 1.0
        if faces(lanes, here, ux, uy) == against[row]:
            here = match_tracked(lanes, index, 0, lane[row], True, x, y, way * ux, way * uy, -1)
        share, d2 = project(lanes, here, x, y, True)
        held = min(max(share, 0.0), 1.0)
        cross = lanes.dx[here] * (y - lanes.y0_m[here]) - lanes.dy[here] * (x - lanes.x0_m[here])
        segment[row] = here
        lane_offset_m[row] = way * (sqrt(d2) if cross >= 0.0 else -sqrt(d2))
        lane_yaw_rad[row] = lanes.yaw0_rad[here] + held * lanes.turn_rad[here]
        if against[row]:
            lane_yaw_rad[row] = wrap_angle(lane_yaw_rad[row] + pi)
        curvature = (1.0 - held) * lanes.curvature0_per_m[here] + held * lanes.curvature1_per_m[here]
        curvature_per_m[row] = way * curvature
        lane_width_m[row] = sides.width_m[lane[row]]
        marked[row] = not against[row] and not sides.internal[lane[row]] and not sides.internal[lanes.lane[here]]


@kernel
def offsets(
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: int,
    lane: Ints,
    position_m: Floats,
    heading_rad: Floats,
    segment: Ints,
    offset_m: Floats,
) -> None:
    """Match (n, 2) positions one by one: sets (n,) `segment` (-1 where there is no match) and `offset_m`."""
    for i in range(len(lane)):
        x = position_m[i, 0]
        y = position_m[i, 1]
        segment[i] = match(lanes, index, mode, layer, lane[i], x, y, heading_rad[i], -1)
        offset_m[i] = 0.0
        if segment[i] >= 0:
            offset_m[i], cosine = offset_on(lanes, segment[i], x, y, heading_rad[i], mode == TRACKED)
            if abs(cosine) < MIN_COS:
                segment[i] = -1
