"""What lies beside each lane: lanes of the same direction, lanes of the opposite one, or nothing."""

from collections import defaultdict

import numpy as np
import shapely

from gpsec.core.arrays import Floats
from gpsec.hdmap.arrays import LaneSides
from gpsec.hdmap.net import Lane

# Where along the lane one looks across, as shares of its length; the majority decides.
_PLACES = (0.25, 0.5, 0.75)
# From the outer edge of a carriageway to the centre of the first oncoming lane: half a lane, no median.
_LOOK_BEYOND_M = 1.6
_MAX_GAP_M = 1.6
_OPPOSITE_COS = -0.7


def lane_sides(lanes: list[Lane]) -> LaneSides:
    """Return what lies beside each of (L,) lanes, from edges and geometry (also for left-hand traffic)."""
    count = len(lanes)
    width = np.array([lane.width_m for lane in lanes])
    same = np.zeros((2, count))
    edges: dict[int, list[int]] = defaultdict(list)
    for index, lane in enumerate(lanes):
        edges[lane.edge].append(index)
    place = np.array([place_at(lane.shape_m, 0.5) for lane in lanes])
    edge_width = np.zeros(count)
    for members in edges.values():
        for i in members:
            edge_width[i] = width[members].sum()
            for j in members:
                if i != j:
                    dx, dy = place[j, :2] - place[i, :2]
                    left = np.cos(place[i, 2]) * dy - np.sin(place[i, 2]) * dx > 0.0
                    same[0 if left else 1, i] += width[j]
    oncoming = np.zeros((2, count))
    tree = shapely.STRtree([shapely.LineString(lane.shape_m) for lane in lanes])
    internal = np.array([lane.internal for lane in lanes])
    for side, sign in ((0, 1.0), (1, -1.0)):
        votes = np.zeros(count, np.int32)
        found = np.zeros(count)
        for share in _PLACES:
            here = np.array([place_at(lane.shape_m, share) for lane in lanes])
            reach = sign * (0.5 * width + same[side] + _LOOK_BEYOND_M)
            look = here[:, :2] + reach[:, None] * np.stack([-np.sin(here[:, 2]), np.cos(here[:, 2])], axis=1)
            seen: set[int] = set()
            for i, j in _neighbours(tree, look):
                if internal[i] or internal[j] or i in seen:
                    continue
                other = lanes[j].shape_m
                along = shapely.LineString(other).project(shapely.Point(look[i]), normalized=True)
                if np.cos(place_at(other, along)[2] - here[i, 2]) < _OPPOSITE_COS:
                    seen.add(i)
                    votes[i] += 1
                    found[i] = edge_width[j]
        oncoming[side] = np.where(votes * 2 > len(_PLACES), found, 0.0)
    return LaneSides(width, internal, same[0], same[1], oncoming[0], oncoming[1])


def _neighbours(tree: shapely.STRtree, look: Floats) -> list[tuple[int, int]]:
    pairs = tree.query(shapely.points(look), predicate="dwithin", distance=_MAX_GAP_M)
    return sorted((i, j) for i, j in pairs.T.tolist())


def place_at(shape_m: Floats, share: float) -> tuple[float, float, float]:
    """Return x, y and direction at a share of the length."""
    step = np.diff(shape_m, axis=0)
    length = np.hypot(step[:, 0], step[:, 1])
    s = np.concatenate([[0.0], np.cumsum(length)])
    at = share * s[-1]
    k = min(int(np.searchsorted(s, at, side="right")) - 1, len(step) - 1)
    part = (at - s[k]) / length[k]
    x, y = shape_m[k] + part * step[k]
    return float(x), float(y), float(np.arctan2(step[k, 1], step[k, 0]))
