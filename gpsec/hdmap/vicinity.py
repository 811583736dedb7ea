"""Lists of the lane segments about every vehicle, so that matching need not search the map.

All positions that are matched for a vehicle (its axle, its fix under every plan, the sigma points of every estimate)
lie within metres of each other and move little from step to step. So each vehicle keeps a list of the segments of its
lane's chain that are within some distance of a centre, as molecular dynamics keeps the neighbours of an atom (L. Verlet,
Physical Review 159, 1967). A match from the list is exact where no segment outside of it can be nearer: one that is
further than R from the centre is further than R - |position - centre| from the position.
"""

from math import cos, inf, sin, sqrt
from typing import NamedTuple

import numpy as np

from gpsec.arrays import Floats, Ints
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.hdmap.search import better, gather_tracked, match_tracked, project
from gpsec.kernels import inline, kernel
from gpsec.threads import Threads

# Segments that a list has room for; where there are more, the list reaches less far.
ROOM = 64
# How far a list reaches, about a centre that lies ahead of the vehicle.
RADIUS_M = 20.0
AHEAD_M = 10.0
# A list is made anew when the vehicle comes as near as this to its rim, so that fixes and estimates beside the vehicle
# are still well inside.
MARGIN_M = 6.0
# Distances are compared with this much to spare, for rounding.
_SPARE_M = 1e-6


class Vicinity(NamedTuple):
    """The lists of N vehicle rows.

    Attributes:
        lane, layer: (N,) whose chain is listed, in which layer of the map; -1 before the first list.
        centre_m: (N, 2) of the list.
        within_m: (N,) all segments of the chain that are at most this far from the centre are listed.
        count: (N,) length of the list.
        segment: (N, ROOM) the list.
    """

    lane: Ints
    layer: Ints
    centre_m: Floats
    within_m: Floats
    count: Ints
    segment: Ints


def no_vicinity(capacity: int) -> Vicinity:
    """Return room for the lists of `capacity` vehicle rows; none is made yet."""
    return Vicinity(
        lane=np.full(capacity, -1, np.int32),
        layer=np.full(capacity, -1, np.int32),
        centre_m=np.zeros((capacity, 2)),
        within_m=np.zeros(capacity),
        count=np.zeros(capacity, np.int32),
        segment=np.zeros((capacity, ROOM), np.int32),
    )


class Lookout:
    """Keeps the lists of a growing fleet.

    A list says what it holds and the map does not change, so that lists may be out of date and rows need no reset: what
    a list cannot answer is searched for.

    Attributes:
        vicinity: the lists.
    """

    def __init__(self, lanes: MapArrays, index: MatchIndex) -> None:
        self._lanes = lanes
        self._index = index
        self.vicinity = no_vicinity(1)

    def look(
        self,
        rows: Ints,
        layer_of_profile: Ints,
        profile: Ints,
        lane: Ints,
        rear_m: Floats,
        yaw_rad: Floats,
        threads: Threads,
    ) -> None:
        """Bring the lists of the vehicle rows `rows` up to date; the arrays are fields of `Vehicles`."""
        if len(lane) > len(self.vicinity.lane):
            self.vicinity = no_vicinity(len(lane))
        threads.run(
            _look, rows, self._lanes, self._index, layer_of_profile, profile, lane, rear_m, yaw_rad, self.vicinity
        )


@kernel
def _look(
    rows: Ints,
    lanes: MapArrays,
    index: MatchIndex,
    layer_of_profile: Ints,
    profile: Ints,
    lane: Ints,
    rear_m: Floats,
    yaw_rad: Floats,
    near: Vicinity,
) -> None:
    for row in rows:
        layer = layer_of_profile[profile[row]]
        x = rear_m[row, 0]
        y = rear_m[row, 1]
        if _is_for(near, row, layer, lane[row]) and _from_centre(near, row, x, y) <= near.within_m[row] - MARGIN_M:
            continue
        near.lane[row] = lane[row]
        near.layer[row] = layer
        share = 1.0
        for _ in range(4):
            within = share * RADIUS_M
            x = rear_m[row, 0] + share * AHEAD_M * cos(yaw_rad[row])
            y = rear_m[row, 1] + share * AHEAD_M * sin(yaw_rad[row])
            count = gather_tracked(lanes, index, layer, lane[row], x, y, within, near.segment[row])
            if count >= 0:
                break
            share *= 0.5
        near.centre_m[row, 0] = x
        near.centre_m[row, 1] = y
        near.within_m[row] = within
        near.count[row] = max(count, 0)
        if count < 0:
            near.within_m[row] = 0.0


@inline
def _is_for(near: Vicinity, row: int, layer: int, lane: int) -> bool:
    return row < len(near.lane) and near.lane[row] == lane and near.layer[row] == layer


@inline
def _from_centre(near: Vicinity, row: int, x_m: float, y_m: float) -> float:
    dx = x_m - near.centre_m[row, 0]
    dy = y_m - near.centre_m[row, 1]
    return sqrt(dx * dx + dy * dy)


@inline
def match_near(
    lanes: MapArrays,
    index: MatchIndex,
    near: Vicinity,
    row: int,
    layer: int,
    lane: int,
    x_m: float,
    y_m: float,
    hint: int,
) -> int:
    """Return what `match_tracked` does, for a position about the vehicle row `row`."""
    if _is_for(near, row, layer, lane):
        best = -1
        best_d2 = inf
        for k in range(near.count[row]):
            best, best_d2 = better(lanes, near.segment[row, k], x_m, y_m, best, best_d2)
        if best >= 0 and sqrt(best_d2) + _from_centre(near, row, x_m, y_m) + _SPARE_M <= near.within_m[row]:
            return best
    return match_tracked(lanes, index, layer, lane, x_m, y_m, hint)


@inline
def gather_near(
    lanes: MapArrays,
    index: MatchIndex,
    near: Vicinity,
    row: int,
    layer: int,
    lane: int,
    x_m: float,
    y_m: float,
    within_m: float,
    found: Ints,
) -> int:
    """Do what `gather_tracked` does, for a position about the vehicle row `row`."""
    if (
        not _is_for(near, row, layer, lane)
        or within_m + _from_centre(near, row, x_m, y_m) + _SPARE_M > near.within_m[row]
    ):
        return gather_tracked(lanes, index, layer, lane, x_m, y_m, within_m, found)
    count = 0
    for k in range(near.count[row]):
        segment = near.segment[row, k]
        _, d2 = project(lanes, segment, x_m, y_m, True)
        if d2 <= within_m * within_m:
            found[count] = segment
            count += 1
    return count
