"""What a displacement means, of a vehicle that has truly left the middle of its path."""

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.state import LINE_TOUCHED, OFF_ROAD, OUT_OF_LANE, WRONG_WAY


def reached(displaced_m: Floats, width_m: Floats, lane: Ints, sides: LaneSides) -> Flags:
    """Return (n, 4) which outcomes vehicles have reached, none where their lane is within a junction.

    Args:
        displaced_m: (n,) from the middle of the lane, left positive.
        width_m: (n,) of the bodies.
        lane: (n,) their lanes.
        sides: what lies beside all lanes. The limits are those of the outcomes in open loop, which are of the error.
    """
    left = displaced_m > 0.0
    same = np.where(left, sides.same_left_m[lane], sides.same_right_m[lane])
    oncoming = np.where(left, sides.oncoming_left_m[lane], sides.oncoming_right_m[lane])
    lane_m, far_m = sides.width_m[lane], np.abs(displaced_m)
    beyond_m = 0.5 * (lane_m + width_m) + same
    found = np.zeros((len(lane), 4), np.bool_)
    found[:, LINE_TOUCHED] = far_m > 0.5 * (lane_m - width_m)
    found[:, OUT_OF_LANE] = far_m > 0.5 * lane_m
    found[:, WRONG_WAY] = (oncoming > 0.0) & (far_m > beyond_m)
    found[:, OFF_ROAD] = far_m > beyond_m + oncoming
    return found & ~sides.internal[lane][:, None]
