"""The lanes of SUMO's net as arrays, by their index in the HD map: how they lie side by side, and where they lead.

SUMO's own left is where the numbers of lanes grow. Where traffic keeps left, that is the right: its lateral positions
are mirrored, and so is all that is here.
"""

from collections import defaultdict
from collections.abc import Mapping
from itertools import pairwise
from math import atan2, hypot, pi
from pathlib import Path
from typing import NamedTuple

import libsumo
import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.traffic.inputs import first_match

_KEEPS_LEFT = rb"""<net\b[^>]*\slefthand\s*=\s*["'](true|1)["']"""


class LaneArrays(NamedTuple):
    """Lanes of a running simulation; L of them, with P points.

    Attributes:
        left_sign: (1,) 1 where SUMO's left is the left, -1 where traffic keeps left.
        edge: (L,) number of the edge.
        internal: (L,) inside a junction.
        middle_m: (L,) distance of its centre from SUMO's right side of the edge.
        width_m, length_m: (L,) as SUMO has them.
        left, right: (L,) next lane of the same edge on that side of SUMO's, -1 where there is none.
        first: (L + 1,) first point of each lane, and P.
        at_m, yaw_rad: (P,) length of the shape up to each point, and the mean direction there.
        stretch: (L,) metres of the shape for one of the length.
    """

    left_sign: Floats
    edge: Ints
    internal: Flags
    middle_m: Floats
    width_m: Floats
    length_m: Floats
    left: Ints
    right: Ints
    first: Ints
    at_m: Floats
    yaw_rad: Floats
    stretch: Floats


class SumoLanes:
    """Lanes of a running simulation.

    Attributes:
        ids: SUMO's id of each.
        now: the same lanes as arrays.
    """

    def __init__(self, lane_index: Mapping[str, int], net_file: Path) -> None:
        self.ids = [""] * (1 + max(lane_index.values()))
        for name, index in lane_index.items():
            self.ids[index] = self.ids[index] or name
        count = len(self.ids)
        length_m = np.array([libsumo.lane.getLength(name) for name in self.ids])
        lines = [_line(libsumo.lane.getShape(name)) for name in self.ids]
        self.now = LaneArrays(
            left_sign=np.array([-1.0 if first_match(net_file, _KEEPS_LEFT) else 1.0]),
            edge=np.zeros(count, np.int32),
            internal=np.array([name.startswith(":") for name in self.ids]),
            middle_m=np.zeros(count),
            width_m=np.array([libsumo.lane.getWidth(name) for name in self.ids]),
            length_m=length_m,
            left=np.full(count, -1, np.int32),
            right=np.full(count, -1, np.int32),
            first=np.cumsum([0, *(len(at_m) for at_m, _ in lines)], dtype=np.int32),
            at_m=np.concatenate([at_m for at_m, _ in lines]),
            yaw_rad=np.concatenate([yaw_rad for _, yaw_rad in lines]),
            stretch=np.array([at_m[-1] for at_m, _ in lines]) / length_m,
        )
        members: dict[str, list[tuple[int, int]]] = defaultdict(list)
        for index, name in enumerate(self.ids):
            edge, _, place = name.rpartition("_")
            members[edge].append((int(place), index))
        for number, lanes in enumerate(members.values()):
            self._side_by_side(number, [index for _, index in sorted(lanes)])

    def _side_by_side(self, edge: int, lanes: list[int]) -> None:
        """Note where the lanes of an edge lie, from SUMO's right to its left."""
        now, reached_m, before = self.now, 0.0, -1
        for lane in lanes:
            now.edge[lane] = edge
            now.middle_m[lane] = reached_m + 0.5 * now.width_m[lane]
            reached_m += now.width_m[lane]
            now.right[lane] = before
            if before >= 0:
                now.left[before] = lane
            before = lane


def _line(shape: tuple[tuple[float, ...], ...]) -> tuple[list[float], list[float]]:
    """Return lengths and directions at the points of a lane; directions go on beyond π."""
    points = [point[:2] for point in shape]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points) if a != b]
    at_m, course = [0.0], list[float]()
    for dx, dy in steps:
        at_m.append(at_m[-1] + hypot(dx, dy))
        yaw = atan2(dy, dx)
        course.append(yaw if not course else course[-1] + (yaw - course[-1] + pi) % (2.0 * pi) - pi)
    inner = [0.5 * (a + b) for a, b in pairwise(course)]
    return at_m, [course[0], *inner, course[-1]]
