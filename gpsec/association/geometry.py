"""Where a hypothesis is beside its lane."""

from math import cos, floor
from typing import NamedTuple

from gpsec.association.state import Association, Place, propose
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.hdmap.arrays import MapArrays, Roads
from gpsec.hdmap.search import Ray, match_tracked, project

# Segments of a lane that are passed in one step; more than any vehicle does.
_STRIDE = 12
# Squared metres from the place that a search starts from weigh so much less: it orders what does not fit in.
FAR = 0.1


class Lateral(NamedTuple):
    """A position beside a lane.

    Attributes:
        offset_m: d1 of Eq 6, left positive.
        cosine: of the lane's direction less the heading; with `MIN_COS` or less there is no offset to speak of.
        turn_rad: the lane's direction less the heading.
        nx, ny: unit vector to the left of the lane.
        curvature_per_m: of the lane.
    """

    offset_m: float
    cosine: float
    turn_rad: float
    nx: float
    ny: float
    curvature_per_m: float


@inline
def beside(lanes: MapArrays, segment: int, x_m: float, y_m: float, heading_rad: float) -> Lateral:
    """Return how a position lies beside a segment."""
    dx, dy = lanes.dx[segment], lanes.dy[segment]
    rx, ry = x_m - lanes.x0_m[segment], y_m - lanes.y0_m[segment]
    held = min(max((rx * dx + ry * dy) / lanes.length_m[segment], 0.0), 1.0)
    turn = wrap_angle(lanes.yaw0_rad[segment] + held * lanes.turn_rad[segment] - heading_rad)
    cosine = cos(turn)
    # Past its ends a lane goes straight on, so that no error along it becomes one across.
    offset = (dx * ry - dy * rx) / max(cosine, 1e-3)
    curvature = (1.0 - held) * lanes.curvature0_per_m[segment] + held * lanes.curvature1_per_m[segment]
    return Lateral(offset, cosine, turn, -dy, dx, curvature)


@inline
def variance_across(place: Place, at: Lateral) -> float:
    """Return the variance of a position across the lane."""
    nx, ny = at.nx, at.ny
    return float(place.xx * nx * nx + 2.0 * place.xy * nx * ny + place.yy * ny * ny)


@inline
def variance_along(place: Place, at: Lateral) -> float:
    """Return the variance of a position along the lane."""
    nx, ny = at.nx, at.ny
    return float(place.xx * ny * ny - 2.0 * place.xy * nx * ny + place.yy * nx * nx)


@inline
def walk_on(roads: Roads, layer: int, lane: int, segment: int, x_m: float, y_m: float) -> tuple[int, bool]:
    """Return the segment of a lane beside a position, going on from `segment`, and whether the lane's end is passed."""
    lanes = roads.lanes
    first = lanes.first[layer, lane]
    last = first + lanes.segments[layer, lane] - 1
    for _ in range(_STRIDE):
        along = (x_m - lanes.x0_m[segment]) * lanes.dx[segment] + (y_m - lanes.y0_m[segment]) * lanes.dy[segment]
        if along > lanes.length_m[segment]:
            if segment == last:
                return segment, True
            segment += 1
        elif along < 0.0 and segment > first:
            before = segment - 1
            reached = (x_m - lanes.x0_m[before]) * lanes.dx[before] + (y_m - lanes.y0_m[before]) * lanes.dy[before]
            if reached > lanes.length_m[before]:
                return segment, False  # outside a bend, between the two
            segment = before
        else:
            return segment, False
    return segment, False


@inline
def propose_beside(
    state: Association, row: int, roads: Roads, layer: int, h: int, left: bool, ray: Ray, weight: float
) -> None:
    """Propose the lane next to that of a hypothesis, where there is one that leads the vehicle's way."""
    lane = state.lane[row, h]
    other = roads.graph.left[lane] if left else roads.graph.right[lane]
    if other < 0:
        return
    segment = match_tracked(roads.lanes, roads.lookup, layer, other, False, ray, -1)
    if segment >= 0:
        P = state.covariance[row, h]
        propose(state, row, other, segment, Place(ray.x_m, ray.y_m, P[0], P[1], P[2]), weight)


@inline
def propose_around(
    state: Association, row: int, roads: Roads, layer: int, ray: Ray, variance: float, reach_m: float
) -> None:
    """Propose all lanes within `reach_m` of a position that lead the vehicle's way, to within 60°."""
    lanes, index = roads.lanes, roads.lookup
    columns, lines = index.grid_columns[0], index.grid_rows[0]
    column = floor((ray.x_m - index.grid_x_m[0]) / index.grid_cell_m[0])
    line = floor((ray.y_m - index.grid_y_m[0]) / index.grid_cell_m[0])
    for r in range(max(line - 1, 0), min(line + 1, lines - 1) + 1):
        for c in range(max(column - 1, 0), min(column + 1, columns - 1) + 1):
            cell = (layer * lines + r) * columns + c
            for position in range(index.grid_first[cell], index.grid_first[cell + 1]):
                chunk = index.grid_chunk[position]
                dx, dy = ray.x_m - index.chunk_x_m[chunk], ray.y_m - index.chunk_y_m[chunk]
                far = index.chunk_radius_m[chunk] + reach_m
                if dx * dx + dy * dy > far * far:
                    continue
                first = index.chunk_segment[chunk]
                for segment in range(first, first + index.chunk_segments[chunk]):
                    _, d2 = project(lanes, segment, ray.x_m, ray.y_m, False)
                    ahead = lanes.dx[segment] * ray.ux + lanes.dy[segment] * ray.uy
                    if d2 <= reach_m * reach_m and ahead >= 0.5:
                        place = Place(ray.x_m, ray.y_m, variance, 0.0, variance)
                        propose(state, row, lanes.lane[segment], segment, place, -FAR * d2)
