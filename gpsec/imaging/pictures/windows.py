"""Sliding windows: along both lines, window by window, the marks that are taken to be of them."""

import numpy as np

from gpsec.core.arrays import Flags
from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.search import LanePair

# Half width of a window, and where windows end: longer the farther away, as marks become fewer.
HALF_M = 0.35
_ENDS_M = np.array([8.0, 10.0, 12.5, 15.0, 18.0, 21.5, 25.5, 30.0, 35.0, 40.0, 46.0])


def slide(marks: Marks, pair: LanePair) -> tuple[Flags, Flags]:
    """Return (n,) which of n marks are of the left line, and which of the right one.

    A pair of windows lies where the lines were in the windows before, moved on as the road bends. What they hold moves
    the next pair, both together: the lines are parallel, and where one has a gap the other one leads.
    """
    bent = marks.y_m - pair.turn * marks.x_m - pair.bend * marks.x_m**2
    window = np.searchsorted(_ENDS_M, marks.x_m)
    off = np.stack([bent - pair.left_m, bent - pair.right_m])
    aside, slope, last_m = 0.0, 0.0, float(_ENDS_M[0]) - 1.5
    kept = np.zeros(off.shape, np.bool_)
    for number, end_m in enumerate(_ENDS_M.tolist()):
        middle_m = end_m - 1.5
        expected = aside + slope * (middle_m - last_m)
        inside = (np.abs(off - expected) <= HALF_M) & (window == number)
        if not inside.any():
            continue
        weight = marks.strength * inside
        where = float((weight * off).sum() / weight.sum())
        if kept.any():
            slope = 0.5 * slope + 0.5 * (where - aside) / max(middle_m - last_m, 2.0)
        aside, last_m = where, middle_m
        kept |= inside
    return kept[0], kept[1]
