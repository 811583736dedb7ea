"""What a map does not say of a lane between two of its points.

The points lie on the lane, `h` apart. Between them the lane is taken for the arc that turns as the directions at the
points do (`gpsec.hdmap.matching.view_on`). Where the curvature changes, it is not: the directions at the points are
means over the chords that meet, and the arc is not the lane. How much it changes, the map tells: the kinks at the two
ends of a segment differ by d. A step of the curvature anywhere among points of equal distance makes errors whose root
mean squares, over where it is and over the segments, are 0.278 |d| of direction and 0.034 |d| h of offset; a curvature
that grows evenly, 0.253 |d| and 0.006 |d| h.

At an end of a lane the direction is drawn on, so that both kinks are the same and tell nothing. There d is the inner
kink itself, as if the curvature could end on the segment: of the direction errors on `sharp_turns` that are over three
times as large as stated without that (points 4 m apart), all are at such ends.
"""

from math import atan2

from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.localization.world import World

# Errors of direction and offset in units of d and of d·h, for a step of the curvature.
DIRECTION_SHARE, OFFSET_SHARE = 0.278, 0.034
# A vehicle that is slower than this stands, and sees the same error again and again.
_STANDING_MPS = 0.03


@inline
def map_variances(world: World, segment: int, profile: int, speed_mps: float) -> tuple[float, float]:
    """Return the variances of offset and direction with which a camera sample is compared on a segment.

    The error lasts for the whole segment, in which n samples fall: the variance of each is n times as large, as if all
    of them together were one.
    """
    lanes = world.hd_map.lanes
    layer, lane = world.hd_map.layer[profile], lanes.lane[segment]
    first = lanes.first[layer, lane]
    if first < segment < first + lanes.segments[layer, lane] - 1:
        before = wrap_angle(lanes.yaw0_rad[segment] - atan2(lanes.dy[segment], lanes.dx[segment]))
        d = 2.0 * (2.0 * before + lanes.turn_rad[segment])
    else:
        d = lanes.turn_rad[segment]
    h = lanes.length_m[segment]
    way = max(abs(speed_mps), _STANDING_MPS) * world.noise.camera_period_s[profile]
    n = max(h / way, 1.0)
    offset, direction = OFFSET_SHARE * d * h, DIRECTION_SHARE * d
    return float(n * offset * offset), float(n * direction * direction)
