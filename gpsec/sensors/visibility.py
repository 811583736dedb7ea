"""Where a lane camera has enough of both lines ahead, by place: paint, stop lines and who drives in front.

A lane is seen where each of its lines is there for at least `NEEDED_M` of the way from `NEAR_M` to `FAR_M` ahead of the
rear axle, on the lane itself and on from it up to the next junction, and nobody hides it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.core.kernels import kernel
from gpsec.core.threads import Threads
from gpsec.hdmap.map import HDMap
from gpsec.types.paint import PaintedLane
from gpsec.types.vehicles import Vehicles

NEAR_M, FAR_M, NEEDED_M = 6, 40, 9.0
_NOBODY_M = 1e9


class PaintedMap(NamedTuple):
    """Lines by the metre of each of L lanes, and where its S segments (of the true geometry) begin along it.

    Attributes:
        first: (L,) first metre of a lane in what follows; metres: (L,) how many it has.
        left, right: (M,) there is a line beside that metre.
        next: (L,) lane that it leads to, -1 where it leads into a junction, or nowhere.
        begin_m: (S,) of a segment along its lane.
        x0_m, y0_m, dx, dy: (S,) as in `MapArrays`; lane: (S,).
    """

    first: Ints
    metres: Ints
    left: Flags
    right: Flags
    next: Ints
    begin_m: Floats
    x0_m: Floats
    y0_m: Floats
    dx: Floats
    dy: Floats
    lane: Ints


@kernel
def place_along(rows: Ints, vehicles: Vehicles, paint: PaintedMap, along_m: Floats) -> None:
    """Say how far along the lane of its rear axle each vehicle is."""
    for row in rows:
        segment = vehicles.segment[row]
        x, y = vehicles.rear_m[row, 0] - paint.x0_m[segment], vehicles.rear_m[row, 1] - paint.y0_m[segment]
        along_m[row] = paint.begin_m[segment] + paint.dx[segment] * x + paint.dy[segment] * y


@kernel
def look_ahead(
    rows: Ints, vehicles: Vehicles, by_place: Flags, paint: PaintedMap, along_m: Floats, free_m: Floats
) -> None:
    """Take the marks of those that have too little of a line ahead; `free_m` is how far nobody hides it."""
    for row in rows:
        if not vehicles.marked[row] or not by_place[vehicles.profile[row]]:
            continue
        lane = paint.lane[vehicles.segment[row]]
        metre = floor(along_m[row])
        left, right = 0.0, 0.0
        for ahead in range(FAR_M):
            while lane >= 0 and metre + ahead >= paint.metres[lane]:
                metre -= paint.metres[lane]
                lane = paint.next[lane]
            if lane < 0 or ahead >= free_m[row]:
                break
            at = paint.first[lane] + max(metre + ahead, 0)
            if ahead >= NEAR_M:
                left += paint.left[at]
                right += paint.right[at]
        vehicles.marked[row] = left >= NEEDED_M and right >= NEEDED_M


@dataclass(frozen=True)
class Visibility:
    """What cameras see by place.

    Attributes:
        paint: of the true map.
        by_place: (P,) the cameras of a profile lose the lane by place.
    """

    paint: PaintedMap
    by_place: Flags

    @classmethod
    def on(cls, hd_map: HDMap, stretches: Sequence[PaintedLane], by_place: Flags) -> "Visibility":
        """Return what is seen on a map; lanes that no stretch names have lines on both sides all along."""
        return cls(_painted(hd_map, stretches), by_place)

    def limit(self, rows: Ints, vehicles: Vehicles, threads: Threads) -> None:
        """Take `Vehicles.marked` of those whose cameras have too little to see in this step."""
        along_m = np.zeros(len(vehicles.lane))
        threads.run(place_along, rows, vehicles, self.paint, along_m)
        free_m = _free_ahead(rows, vehicles, self.paint, along_m)
        threads.run(look_ahead, rows, vehicles, self.by_place, self.paint, along_m, free_m)


def _free_ahead(rows: Ints, vehicles: Vehicles, paint: PaintedMap, along_m: Floats) -> Floats:
    """Return (N,) from each rear axle to the rear of the next vehicle of the fleet on its lane, or on the next lane."""
    free_m = np.full(len(vehicles.lane), _NOBODY_M)
    lane = paint.lane[vehicles.segment[rows]]
    here = along_m[rows]
    tail = here - (vehicles.length_m[rows] - vehicles.axle_m[rows])
    order = np.lexsort((here, lane))
    follows = lane[order[1:]] == lane[order[:-1]]
    behind, ahead = order[:-1][follows], order[1:][follows]
    free_m[rows[behind]] = tail[ahead] - here[behind]
    # The first of each lane looks on into the next one, at its last.
    leads, comes_last = np.ones(len(rows), np.bool_), np.ones(len(rows), np.bool_)
    leads[:-1], comes_last[1:] = ~follows, ~follows
    last_m = np.full(len(paint.next) + 1, _NOBODY_M)  # of no lane, -1, nobody is the last
    last_m[lane[order[comes_last]]] = tail[order[comes_last]]
    first = order[leads]
    free_m[rows[first]] = paint.metres[lane[first]] - here[first] + last_m[paint.next[lane[first]]]
    return free_m


def _painted(hd_map: HDMap, stretches: Sequence[PaintedLane]) -> PaintedMap:
    lanes = hd_map.lanes
    count = len(hd_map.lane_ids)
    begin_m = np.zeros(len(lanes.length_m))
    metres = np.zeros(count, np.int32)
    for lane in range(count):
        run = slice(lanes.first[0, lane], lanes.first[0, lane] + lanes.segments[0, lane])
        ends_m = np.cumsum(lanes.length_m[run])
        begin_m[run] = ends_m - lanes.length_m[run]
        metres[lane] = max(int(np.ceil(ends_m[-1])), 1)
    first: Longs = np.cumsum(metres, dtype=np.int64) - metres
    left, right = np.ones(int(metres.sum()), np.bool_), np.ones(int(metres.sum()), np.bool_)
    for one in stretches:
        index = hd_map.lane_index.get(one.lane)
        if index is None:
            continue
        run = slice(
            first[index] + min(int(one.begin_m + 0.5), metres[index]),
            first[index] + min(int(one.end_m + 0.5), metres[index]),
        )
        left[run], right[run] = one.left, one.right
    graph = hd_map.graph
    following = np.full(count, -1, np.int32)
    for lane in range(count):
        after = graph.after_lane[graph.after_first[lane] : graph.after_first[lane] + graph.after_count[lane]]
        outside = after[~hd_map.sides.internal[after]]
        if len(outside) and len(outside) == len(after):
            following[lane] = outside[0]
    return PaintedMap(
        first=first.astype(np.int32),
        metres=metres,
        left=left,
        right=right,
        next=following,
        begin_m=begin_m,
        x0_m=lanes.x0_m,
        y0_m=lanes.y0_m,
        dx=lanes.dx,
        dy=lanes.dy,
        lane=lanes.lane,
    )
