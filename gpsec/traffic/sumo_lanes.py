"""The lanes of SUMO's net as arrays, by their index in the HD map: how they lie side by side, and where they lead.

SUMO's own left is where the numbers of lanes grow. Where traffic keeps left, that is the right: its lateral positions
are mirrored, and so is all that is here.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from math import atan2, cos, hypot, pi, sin
from pathlib import Path

import libsumo
import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.traffic.inputs import first_match

_KEEPS_LEFT = rb"""<net\b[^>]*\slefthand\s*=\s*["'](true|1)["']"""


class SumoLanes:
    """Lanes of a running simulation; L of them.

    Attributes:
        ids: SUMO's id of each.
        left_sign: 1 where SUMO's left is the left, -1 where traffic keeps left.
        edge: (L,) number of the edge.
        internal: (L,) inside a junction.
        middle_m: (L,) distance of its centre from SUMO's right side of the edge.
        width_m, length_m: (L,) as SUMO has them.
        left, right: (L,) next lane of the same edge on that side of SUMO's, -1 where there is none.
    """

    def __init__(self, lane_index: Mapping[str, int], net_file: Path) -> None:
        self.left_sign = -1.0 if first_match(net_file, _KEEPS_LEFT) else 1.0
        count = 1 + max(lane_index.values())
        self.ids = [""] * count
        for name, index in lane_index.items():
            self.ids[index] = self.ids[index] or name
        self.width_m: Floats = np.array([libsumo.lane.getWidth(name) for name in self.ids])
        self.length_m: Floats = np.array([libsumo.lane.getLength(name) for name in self.ids])
        self.internal: Flags = np.array([name.startswith(":") for name in self.ids])
        self.edge: Ints = np.zeros(count, np.int32)
        self.middle_m: Floats = np.zeros(count)
        self.left: Ints = np.full(count, -1, np.int32)
        self.right: Ints = np.full(count, -1, np.int32)
        members: dict[str, list[tuple[int, int]]] = defaultdict(list)
        for index, name in enumerate(self.ids):
            edge, _, place = name.rpartition("_")
            members[edge].append((int(place), index))
        for number, lanes in enumerate(members.values()):
            self._side_by_side(number, [index for _, index in sorted(lanes)])

    def _side_by_side(self, edge: int, lanes: list[int]) -> None:
        """Note where the lanes of an edge lie, from the right to the left."""
        reached_m, before = 0.0, -1
        for lane in lanes:
            self.edge[lane] = edge
            self.middle_m[lane] = reached_m + 0.5 * self.width_m[lane]
            reached_m += self.width_m[lane]
            self.right[lane] = before
            if before >= 0:
                self.left[before] = lane
            before = lane

    def left_of(self, lane: int, position_m: float) -> tuple[float, float]:
        """Return the unit vector to the true left of a lane at a position along it; it turns evenly between points."""
        at_m, yaw_rad, stretch = self._line(lane)
        s = position_m * stretch
        k = min(max(bisect_right(at_m, s) - 1, 0), len(at_m) - 2)
        share = min(max((s - at_m[k]) / (at_m[k + 1] - at_m[k]), 0.0), 1.0)
        yaw = yaw_rad[k] + share * (yaw_rad[k + 1] - yaw_rad[k])
        return -sin(yaw), cos(yaw)

    @cache  # noqa: B019 - as long as the simulation
    def _line(self, lane: int) -> tuple[list[float], list[float], float]:
        """Return lengths and directions at the points of a lane, and metres of its shape for one of its length."""
        points = [point[:2] for point in libsumo.lane.getShape(self.ids[lane])]
        steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points) if a != b]
        at_m, course = [0.0], list[float]()
        for dx, dy in steps:
            at_m.append(at_m[-1] + hypot(dx, dy))
            yaw = atan2(dy, dx)
            course.append(yaw if not course else course[-1] + (yaw - course[-1] + pi) % (2.0 * pi) - pi)
        inner = [0.5 * (a + b) for a, b in pairwise(course)]
        return at_m, [course[0], *inner, course[-1]], at_m[-1] / float(self.length_m[lane])
