"""The HD map as arrays that kernels read."""

from typing import NamedTuple

from gpsec.arrays import Flags, Floats, Ints


class LaneSides(NamedTuple):
    """What lies beside each of L lanes, in the direction of the lane; widths in metres, 0 where there is none.

    Attributes:
        width_m: (L,) of the lane itself.
        internal: (L,) inside a junction, without markings.
        same_left_m, same_right_m: (L,) total width of the lanes of the same direction on that side.
        oncoming_left_m, oncoming_right_m: (L,) total width of the lanes of the opposite direction beyond those.
    """

    width_m: Floats
    internal: Flags
    same_left_m: Floats
    same_right_m: Floats
    oncoming_left_m: Floats
    oncoming_right_m: Floats


class MapArrays(NamedTuple):
    """Lane centre lines in one or more layers; layer 0 is the true geometry, others are resampled for a profile.

    L lanes, Y layers, S segments in all. The segments of lane l in layer y are ``first[y, l]`` up to (not including)
    ``first[y, l] + count[y, l]``, in driving order.

    Attributes:
        first, count: (Y, L) CSR of segments.
        lane: (S,) lane of a segment.
        x0_m, y0_m: (S,) start point in the net's frame.
        dx, dy: (S,) unit vector along the segment.
        length_m: (S,) of the segment.
        s_m: (S,) arc length of the lane at the start point.
        yaw0_rad, turn_rad: (S,) smoothed lane direction at the start point and its change along the segment.
        curvature0_per_m, curvature1_per_m: (S,) at start and end point, left positive.
        open_start, open_end: (S,) nothing leads to, or on from, this end of the lane.
    """

    first: Ints
    count: Ints
    lane: Ints
    x0_m: Floats
    y0_m: Floats
    dx: Floats
    dy: Floats
    length_m: Floats
    s_m: Floats
    yaw0_rad: Floats
    turn_rad: Floats
    curvature0_per_m: Floats
    curvature1_per_m: Floats
    open_start: Flags
    open_end: Flags
