"""Map matching (Eqs 2-6): which lane segment a position belongs to, and the signed offset from it.

Two ways of matching. *Tracked*: the nearest point on the chain of the lane that the vehicle believes to be on (that
lane, what leads to it and on from it), as far as it leads the vehicle's way. *Nearest*, the paper's: the nearest point
on any lane whose direction differs by less than 60° from the vehicle's heading.
"""

from math import cos, sqrt
from typing import NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import MapArrays, MatchIndex, Pose
from gpsec.hdmap.search import MIN_COS, TRACKED, match, project


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
