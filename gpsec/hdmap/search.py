"""The search for the nearest lane segment (Eqs 2-5), on a lane's chain or among all lanes.

Both searches are exact; bounding circles only skip what cannot be nearer. Of equally near points the one that comes
first in the map wins. On a chain only segments count that lead the vehicle's way, because where one may turn round the
oncoming lane is part of the chain.
"""

from math import cos, floor, inf, sin, sqrt
from typing import NamedTuple

from gpsec.core.kernels import inline
from gpsec.hdmap.arrays import MapArrays, MatchIndex, Pose

TRACKED, NEAREST = 0, 1
# Beyond 60° between heading and lane, Eq 6 would stretch the offset more than twofold: there is no match. A lane that
# leads the other way is none either.
MIN_COS = 0.5
# Nearest matching looks no further than this from the fix.
_MAX_RINGS = 4


class Ray(NamedTuple):
    """A position in the net's frame, and a unit vector: the way that a segment has to lead, any where it is (0, 0)."""

    x_m: float
    y_m: float
    ux: float
    uy: float


@inline
def project(lanes: MapArrays, segment: int, x_m: float, y_m: float, extend: bool) -> tuple[float, float]:
    """Return the position along a segment (0 … 1) of the point nearest to (x, y), and the squared distance (Eqs 2-5).

    With `extend`, an end of a lane to which nothing is joined continues straight on, so that no along-track error leaks
    into the offset there.
    """
    rx = x_m - lanes.x0_m[segment]
    ry = y_m - lanes.y0_m[segment]
    length = lanes.length_m[segment]
    along = rx * lanes.dx[segment] + ry * lanes.dy[segment]
    if along < 0.0 and not (extend and lanes.open_start[segment]):
        along = 0.0
    elif along > length and not (extend and lanes.open_end[segment]):
        along = length
    ex = rx - along * lanes.dx[segment]
    ey = ry - along * lanes.dy[segment]
    return along / length, ex * ex + ey * ey


@inline
def faces(lanes: MapArrays, segment: int, ux: float, uy: float) -> bool:
    """Return whether a segment leads the way of (ux, uy), or at least not against it; (0, 0) is any way."""
    return bool(lanes.dx[segment] * ux + lanes.dy[segment] * uy >= 0.0)


@inline
def _best_in_chunk(
    lanes: MapArrays, index: MatchIndex, chunk: int, pose: Pose, best: int, best_d2: float
) -> tuple[int, float]:
    first = index.chunk_segment[chunk]
    for segment in range(first, first + index.chunk_segments[chunk]):
        share, d2 = project(lanes, segment, pose.x_m, pose.y_m, False)
        if d2 < best_d2 or (d2 == best_d2 and segment < best):
            held = min(max(share, 0.0), 1.0)
            yaw = lanes.yaw0_rad[segment] + held * lanes.turn_rad[segment]
            if cos(pose.heading_rad - yaw) < MIN_COS:
                continue
            best = segment
            best_d2 = d2
    return best, best_d2


@inline
def better(lanes: MapArrays, segment: int, ray: Ray, best: int, best_d2: float) -> tuple[int, float]:
    """Return the nearer one of `segment`, if it leads the way, and the best so far; of equals, the first."""
    _, d2 = project(lanes, segment, ray.x_m, ray.y_m, True)
    if (d2 < best_d2 or (d2 == best_d2 and segment < best)) and faces(lanes, segment, ray.ux, ray.uy):
        return segment, d2
    return best, best_d2


@inline
def out_of_reach(x_m: float, y_m: float, cx: float, cy: float, radius: float, best_d2: float) -> bool:
    """Nothing inside the circle can be as near as the best so far."""
    if best_d2 == inf:
        return False
    dx = x_m - cx
    dy = y_m - cy
    reach = radius + sqrt(best_d2) + 1e-9
    return dx * dx + dy * dy > reach * reach


@inline
def is_on(lanes: MapArrays, layer: int, lane: int, segment: int) -> bool:
    """Return whether a segment (-1 for none) is one of a lane's in that layer."""
    return bool(lanes.first[layer, lane] <= segment < lanes.first[layer, lane] + lanes.segments[layer, lane])


@inline
def match_tracked(
    lanes: MapArrays, index: MatchIndex, layer: int, lane: int, chained: bool, ray: Ray, hint: int
) -> int:
    """Return the segment of the lane's chain that is nearest to the position of `ray` among those that lead its way.

    Without `chained` only the lane itself is looked at. `hint` is a segment that may be near (-1 for none): it only
    bounds the search. Where no segment leads that way, the result is -1.
    """
    x_m, y_m = ray.x_m, ray.y_m
    best = -1
    best_d2 = inf
    start = index.chain_first[lane]
    bound = inf
    if is_on(lanes, layer, lane, hint) and faces(lanes, hint, ray.ux, ray.uy):
        _, bound = project(lanes, hint, x_m, y_m, True)
        bound = bound * (1.0 + 1e-9) + 1e-12
    for position in range(start, start + (index.chain_count[lane] if chained else 1)):
        if out_of_reach(
            x_m,
            y_m,
            index.chain_x_m[position],
            index.chain_y_m[position],
            index.chain_radius_m[position],
            min(best_d2, bound),
        ):
            continue
        candidate = index.chain_lane[position]
        if index.chain_radius_m[position] == inf:
            # An end that continues straight on may be near although the circles of its segments are not.
            first = lanes.first[layer, candidate]
            last = first + lanes.segments[layer, candidate] - 1
            if lanes.open_start[first]:
                best, best_d2 = better(lanes, first, ray, best, best_d2)
            if lanes.open_end[last]:
                best, best_d2 = better(lanes, last, ray, best, best_d2)
        first_group = index.group_first[layer, candidate]
        for group in range(first_group, first_group + index.group_count[layer, candidate]):
            if out_of_reach(
                x_m,
                y_m,
                index.group_x_m[group],
                index.group_y_m[group],
                index.group_radius_m[group],
                min(best_d2, bound),
            ):
                continue
            first_chunk = index.group_chunk[group]
            for chunk in range(first_chunk, first_chunk + index.group_chunks[group]):
                if out_of_reach(
                    x_m,
                    y_m,
                    index.chunk_x_m[chunk],
                    index.chunk_y_m[chunk],
                    index.chunk_radius_m[chunk],
                    min(best_d2, bound),
                ):
                    continue
                first_segment = index.chunk_segment[chunk]
                for segment in range(first_segment, first_segment + index.chunk_segments[chunk]):
                    best, best_d2 = better(lanes, segment, ray, best, best_d2)
    return best


@inline
def match_nearest(lanes: MapArrays, index: MatchIndex, pose: Pose) -> int:
    """Return the segment of any lane that is nearest to a pose, or -1 where none is within four grid cells."""
    x_m, y_m = pose.x_m, pose.y_m
    columns = index.grid_columns[0]
    rows = index.grid_rows[0]
    cell_m = index.grid_cell_m[0]
    column = floor((x_m - index.grid_x_m[0]) / cell_m)
    row = floor((y_m - index.grid_y_m[0]) / cell_m)
    best = -1
    best_d2 = inf
    for ring in range(_MAX_RINGS + 1):
        # Whatever lies in this ring is at least ring - 1 whole cells away.
        gap = (ring - 1) * cell_m
        if ring > 0 and best >= 0 and gap > 0.0 and gap * gap > best_d2:
            break
        for r in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
            whole = r == row - ring or r == row + ring
            for c in range(max(column - ring, 0), min(column + ring, columns - 1) + 1):
                if not whole and c != column - ring and c != column + ring:
                    continue
                cell = (pose.layer * rows + r) * columns + c
                for position in range(index.grid_first[cell], index.grid_first[cell + 1]):
                    chunk = index.grid_chunk[position]
                    if not out_of_reach(
                        x_m,
                        y_m,
                        index.chunk_x_m[chunk],
                        index.chunk_y_m[chunk],
                        index.chunk_radius_m[chunk],
                        best_d2,
                    ):
                        best, best_d2 = _best_in_chunk(lanes, index, chunk, pose, best, best_d2)
    return best


@inline
def match(lanes: MapArrays, index: MatchIndex, mode: int, pose: Pose, hint: int) -> int:
    """Return the segment that a pose is matched to, -1 where there is none; `hint` is one that may be near, or -1."""
    if mode == TRACKED:
        ray = Ray(pose.x_m, pose.y_m, cos(pose.heading_rad), sin(pose.heading_rad))
        return match_tracked(lanes, index, pose.layer, pose.lane, True, ray, hint)
    return match_nearest(lanes, index, pose)
