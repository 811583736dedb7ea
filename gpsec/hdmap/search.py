"""The search for the nearest lane segment (Eqs 2-5), on a lane's chain or among all lanes.

Both searches are exact; bounding circles only skip what cannot be nearer. Of equally near points the one that comes
first in the map wins.
"""

from math import cos, floor, inf, sqrt

from gpsec.arrays import Ints
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.kernels import inline

TRACKED, NEAREST = 0, 1
MODES = {"tracked": TRACKED, "nearest": NEAREST}
# Beyond 60° between heading and lane, Eq 6 would stretch the offset more than twofold: there is no match.
MIN_COS = 0.5
# Nearest matching looks no further than this from the fix.
_MAX_RINGS = 4


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
def _best_in_chunk(
    lanes: MapArrays,
    index: MatchIndex,
    chunk: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
    nearest: bool,
    best: int,
    best_d2: float,
) -> tuple[int, float]:
    first = index.chunk_segment[chunk]
    for segment in range(first, first + index.chunk_segments[chunk]):
        share, d2 = project(lanes, segment, x_m, y_m, not nearest)
        if d2 < best_d2 or (d2 == best_d2 and segment < best):
            if nearest:
                held = min(max(share, 0.0), 1.0)
                yaw = lanes.yaw0_rad[segment] + held * lanes.turn_rad[segment]
                if abs(cos(heading_rad - yaw)) < MIN_COS:
                    continue
            best = segment
            best_d2 = d2
    return best, best_d2


@inline
def _better(lanes: MapArrays, segment: int, x_m: float, y_m: float, best: int, best_d2: float) -> tuple[int, float]:
    """Return the nearer one of `segment` and the best so far; of equals, the first."""
    _, d2 = project(lanes, segment, x_m, y_m, True)
    if d2 < best_d2 or (d2 == best_d2 and segment < best):
        return segment, d2
    return best, best_d2


@inline
def _out_of_reach(x_m: float, y_m: float, cx: float, cy: float, radius: float, best_d2: float) -> bool:
    """Nothing inside the circle can be as near as the best so far."""
    if best_d2 == inf:
        return False
    dx = x_m - cx
    dy = y_m - cy
    reach = radius + sqrt(best_d2) + 1e-9
    return dx * dx + dy * dy > reach * reach


@inline
def match_tracked(lanes: MapArrays, index: MatchIndex, layer: int, lane: int, x_m: float, y_m: float, hint: int) -> int:
    """Return the segment of the lane's chain that is nearest to (x, y).

    `hint` is a segment that may be near (-1 for none): it only bounds the search.
    """
    best = -1
    best_d2 = inf
    start = index.chain_first[lane]
    bound = inf
    if lanes.first[layer, lane] <= hint < lanes.first[layer, lane] + lanes.segments[layer, lane]:
        _, bound = project(lanes, hint, x_m, y_m, True)
        bound = bound * (1.0 + 1e-9) + 1e-12
    for position in range(start, start + index.chain_count[lane]):
        if _out_of_reach(
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
                best, best_d2 = _better(lanes, first, x_m, y_m, best, best_d2)
            if lanes.open_end[last]:
                best, best_d2 = _better(lanes, last, x_m, y_m, best, best_d2)
        first_group = index.group_first[layer, candidate]
        for group in range(first_group, first_group + index.group_count[layer, candidate]):
            if _out_of_reach(
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
                if _out_of_reach(
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
                    best, best_d2 = _better(lanes, segment, x_m, y_m, best, best_d2)
    return best


@inline
def gather_tracked(
    lanes: MapArrays,
    index: MatchIndex,
    layer: int,
    lane: int,
    x_m: float,
    y_m: float,
    within_m: float,
    near: Ints,
) -> int:
    """List the segments of the lane's chain that are at most `within_m` from (x, y) in `near`.

    Returns their number, or -1 where there is not enough room for them.
    """
    found = 0
    within_d2 = within_m * within_m
    start = index.chain_first[lane]
    for position in range(start, start + index.chain_count[lane]):
        if _out_of_reach(
            x_m,
            y_m,
            index.chain_x_m[position],
            index.chain_y_m[position],
            index.chain_radius_m[position],
            within_d2,
        ):
            continue
        candidate = index.chain_lane[position]
        endless = index.chain_radius_m[position] == inf
        first_group = index.group_first[layer, candidate]
        last_group = first_group + index.group_count[layer, candidate] - 1
        for group in range(first_group, last_group + 1):
            # A group at an end that continues straight on may be near although its circle is not.
            at_end = endless and not first_group < group < last_group
            if not at_end and _out_of_reach(
                x_m,
                y_m,
                index.group_x_m[group],
                index.group_y_m[group],
                index.group_radius_m[group],
                within_d2,
            ):
                continue
            first_chunk = index.group_chunk[group]
            last_chunk = first_chunk + index.group_chunks[group] - 1
            for chunk in range(first_chunk, last_chunk + 1):
                ends = at_end and not first_chunk < chunk < last_chunk
                if not ends and _out_of_reach(
                    x_m,
                    y_m,
                    index.chunk_x_m[chunk],
                    index.chunk_y_m[chunk],
                    index.chunk_radius_m[chunk],
                    within_d2,
                ):
                    continue
                first_segment = index.chunk_segment[chunk]
                for segment in range(first_segment, first_segment + index.chunk_segments[chunk]):
                    _, d2 = project(lanes, segment, x_m, y_m, True)
                    if d2 <= within_d2:
                        if found == len(near):
                            return -1
                        near[found] = segment
                        found += 1
    return found


@inline
def nearest_of(lanes: MapArrays, near: Ints, count: int, x_m: float, y_m: float) -> int:
    """Return the nearest to (x, y) of the first `count` segments in `near`, -1 for none."""
    best = -1
    best_d2 = inf
    for k in range(count):
        best, best_d2 = _better(lanes, near[k], x_m, y_m, best, best_d2)
    return best


@inline
def distance_to(lanes: MapArrays, segment: int, x_m: float, y_m: float) -> float:
    """Return the distance from (x, y) to a segment, whose open ends continue straight on."""
    _, d2 = project(lanes, segment, x_m, y_m, True)
    return sqrt(d2)


@inline
def match_nearest(lanes: MapArrays, index: MatchIndex, layer: int, x_m: float, y_m: float, heading_rad: float) -> int:
    """Return the segment of any lane that is nearest to (x, y), or -1 where none is within four grid cells."""
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
                cell = (layer * rows + r) * columns + c
                for position in range(index.grid_first[cell], index.grid_first[cell + 1]):
                    chunk = index.grid_chunk[position]
                    if not _out_of_reach(
                        x_m,
                        y_m,
                        index.chunk_x_m[chunk],
                        index.chunk_y_m[chunk],
                        index.chunk_radius_m[chunk],
                        best_d2,
                    ):
                        best, best_d2 = _best_in_chunk(lanes, index, chunk, x_m, y_m, heading_rad, True, best, best_d2)
    return best


@inline
def match(
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: int,
    lane: int,
    x_m: float,
    y_m: float,
    heading_rad: float,
    hint: int,
) -> int:
    """Return the matched segment, -1 where there is none."""
    if mode == TRACKED:
        return match_tracked(lanes, index, layer, lane, x_m, y_m, hint)
    return match_nearest(lanes, index, layer, x_m, y_m, heading_rad)
