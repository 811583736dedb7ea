"""How lanes hang together: what each leads to, and what lies beside it in the same direction."""

from collections import defaultdict

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.hdmap.arrays import LaneGraph
from gpsec.hdmap.net import Lane
from gpsec.hdmap.sides import place_at


def lane_graph(lanes: list[Lane]) -> LaneGraph:
    """Return the graph of (L,) lanes: successors, and the lane of the same edge next on either side (-1 for none)."""
    number = {lane.lane_id: index for index, lane in enumerate(lanes)}
    after = [[number[name] for name in lane.successors] for lane in lanes]
    count = np.array([len(one) for one in after], np.int32)
    left, right = _beside(lanes)
    return LaneGraph(
        after_first=(np.cumsum(count) - count).astype(np.int32),
        after_count=count,
        after_lane=np.array([index for one in after for index in one], np.int32),
        left=left,
        right=right,
    )


def _beside(lanes: list[Lane]) -> tuple[Ints, Ints]:
    """Return (L,) next lane to the left and to the right, from the geometry of an edge's lanes."""
    left, right = np.full(len(lanes), -1, np.int32), np.full(len(lanes), -1, np.int32)
    edges: dict[int, list[int]] = defaultdict(list)
    for index, lane in enumerate(lanes):
        edges[lane.edge].append(index)
    middle = [place_at(lane.shape_m, 0.5) for lane in lanes]
    for members in edges.values():
        for i in members:
            x, y, yaw = middle[i]
            nearest = {True: (np.inf, -1), False: (np.inf, -1)}
            for j in members:
                if i != j:
                    across = -np.sin(yaw) * (middle[j][0] - x) + np.cos(yaw) * (middle[j][1] - y)
                    side = bool(across > 0.0)
                    nearest[side] = min(nearest[side], (abs(across), j))
            left[i], right[i] = nearest[True][1], nearest[False][1]
    return left, right
