"""Where the two lines of one's own lane begin: a vote of all marks, for each way that the road may bend ahead."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.birdseye import Marks

# Directions and curvatures (C1, and C2 in 1/m) of the road ahead that are tried, and how far ahead marks have a vote.
_TURNS = np.arange(-6, 7) * 0.02
_BENDS = np.array([-0.025, -0.016, -0.01, -0.006, -0.003, -0.001, 0.0, 0.001, 0.003, 0.006, 0.01, 0.016, 0.025])
_FAR_M = 28.0
# Vehicles drive along their lane, and between its lines: deviation of their direction, and what being on a line costs.
_TURN, _ASKEW = 0.05, 0.3
_BIN_M, _ASIDE_M = 0.1, 4.0
_BINS = round(2.0 * _ASIDE_M / _BIN_M)


class LanePair(NamedTuple):
    """The two lines of a lane as the vote has them.

    Attributes:
        left_m, right_m: at the rear axle.
        turn, bend: C1 and C2 that both have in common.
        left_votes, right_votes: metres of road with a mark on them.
    """

    left_m: float
    right_m: float
    turn: float
    bend: float
    left_votes: float
    right_votes: float


def find_lane(marks: Marks, width_m: tuple[float, float]) -> LanePair | None:
    """Return the lane about the rear axle that has most marks on both of its lines, None where there are none.

    `width_m` are the least and the greatest width that it may have.
    """
    near = (marks.x_m < _FAR_M) & (np.abs(marks.y_m) < _ASIDE_M + 2.0)
    x, y, weight = marks.x_m[near], marks.y_m[near], (marks.strength * np.minimum(marks.row_m, 0.5))[near]
    if not len(x):
        return None
    turn, bend = (grid.ravel() for grid in np.meshgrid(_TURNS, _BENDS, indexing="ij"))
    votes = _votes(x, y, weight, turn, bend)
    least, most = (round(bound / _BIN_M) for bound in width_m)
    # The axle is between the lines, or just beyond one.
    centre = _BINS // 2
    best, found = 0.0, None
    likely = np.exp(-0.5 * (turn / _TURN) ** 2)
    for width in range(least, most + 1):
        lefts = np.arange(max(centre - 4, width), min(centre + width + 4, _BINS - 1))
        left, right = votes[:, lefts], votes[:, lefts - width]
        off = (lefts - 0.5 * width - centre + 0.5) / (0.5 * width)
        both = (np.minimum(left, right) + 0.1 * np.maximum(left, right)) * likely[:, None] * (1.0 - _ASKEW * off * off)
        at = int(np.argmax(both))
        if both.flat[at] > best:
            best = float(both.flat[at])
            way, place = divmod(at, len(lefts))
            found = way, int(lefts[place]), width
    if found is None:
        return None
    way, bin_, width = found
    left_m, right_m = (float((number - centre + 0.5) * _BIN_M) for number in (bin_, bin_ - width))
    both_votes = votes[way, bin_], votes[way, bin_ - width]
    return LanePair(left_m, right_m, float(turn[way]), float(bend[way]), float(both_votes[0]), float(both_votes[1]))


def _votes(x: Floats, y: Floats, weight: Floats, turn: Floats, bend: Floats) -> Floats:
    """Return (H, bins) metres of marks at each offset from the rear axle, if the road were bent in each of H ways."""
    offset = y - turn[:, None] * x - bend[:, None] * (x * x)
    number = np.floor(offset / _BIN_M).astype(np.int64) + _BINS // 2
    inside = (number >= 0) & (number < _BINS)
    number += np.arange(len(turn))[:, None] * _BINS
    weights = np.broadcast_to(weight, number.shape)[inside]
    counted = np.bincount(number[inside], weights, len(turn) * _BINS)
    votes: Floats = np.asarray(counted, np.float64).reshape(len(turn), _BINS)
    votes[:, 1:-1] += 0.5 * (votes[:, :-2] + votes[:, 2:])
    return votes
