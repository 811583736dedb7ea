"""The segments around a position, found once for all sigma points of a filter."""

from math import cos, inf, sin, sqrt

from gpsec.core.arrays import Ints
from gpsec.core.kernels import inline
from gpsec.hdmap.arrays import MapArrays, MatchIndex, Pose
from gpsec.hdmap.search import Ray, better, faces, is_on, match_tracked, out_of_reach, project


@inline
def _gather(lanes: MapArrays, index: MatchIndex, layer: int, lane: int, ray: Ray, within_m: float, near: Ints) -> int:
    """List the segments that lead the way of `ray` and are at most `within_m` from its position in `near`.

    Returns their number, or -1 where there is not enough room for them.
    """
    x_m, y_m = ray.x_m, ray.y_m
    found = 0
    within_d2 = within_m * within_m
    start = index.chain_first[lane]
    for position in range(start, start + index.chain_count[lane]):
        if out_of_reach(
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
            if not at_end and out_of_reach(
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
                if not ends and out_of_reach(
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
                    if d2 <= within_d2 and faces(lanes, segment, ray.ux, ray.uy):
                        if found == len(near):
                            return -1
                        near[found] = segment
                        found += 1
    return found


@inline
def gather_around(
    lanes: MapArrays, index: MatchIndex, pose: Pose, hint: int, spread_m: float, near: Ints
) -> tuple[int, int]:
    """List in `near` all segments of the lane's chain that may be nearest to a position within `spread_m` of `pose`.

    Only those count that lead the way of the heading. Returns their number (-1 where there is not enough room) and a
    segment near the pose; 0 and -1 where none leads that way.
    """
    layer, lane = pose.layer, pose.lane
    ray = Ray(pose.x_m, pose.y_m, cos(pose.heading_rad), sin(pose.heading_rad))
    segment = hint
    if not (is_on(lanes, layer, lane, hint) and faces(lanes, hint, ray.ux, ray.uy)):
        segment = match_tracked(lanes, index, layer, lane, True, ray, hint)
    if segment < 0:
        return 0, -1
    # The nearest to such a position is no further from the pose than any segment of the chain plus twice the spread.
    _, d2 = project(lanes, segment, ray.x_m, ray.y_m, True)
    within = sqrt(d2) + 2.0 * spread_m + 1e-6
    return _gather(lanes, index, layer, lane, ray, within, near), segment


@inline
def nearest_of(lanes: MapArrays, near: Ints, count: int, x_m: float, y_m: float) -> int:
    """Return the nearest to (x, y) of the first `count` segments in `near`, -1 for none."""
    best = -1
    best_d2 = inf
    for k in range(count):
        best, best_d2 = better(lanes, near[k], Ray(x_m, y_m, 0.0, 0.0), best, best_d2)
    return best
