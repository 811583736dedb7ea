"""What weighs the lane hypotheses of a track: the lane that its camera sees, and its heading where it sees none."""

from math import cos, sin

from gpsec.association.geometry import beside, propose_beside, variance_across, variance_along
from gpsec.association.state import Association, correct, most_likely, place_of
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.hdmap.arrays import Roads
from gpsec.hdmap.search import MIN_COS, Ray

# A lane seen further off than this share of the lane's width suggests the neighbour, with this log prior.
SUSPICIOUS, NEIGHBOUR = 0.35, -7.0
# Least log likelihoods of one sample: of the lane's offset, of its direction, and while the camera is blind.
LEAST_OFFSET, LEAST_SLOPE, LEAST_BLIND = -20.0, -4.0, -2.0
SLOPE_SIGMA, HEADING_SIGMA, EDGE_SIGMA_M = 0.03, 0.2, 0.3
# In a bend the lane's direction tells the place along it; samples in turn share their errors, so each counts a tenth.
BEND_PER_M, SLOPE_SAMPLES = 1e-3, 10.0
# Beyond the line by this much, the neighbour is possible.
CROSSED_M = 0.1
# A lane further off than this explains nothing.
CONTRADICTION_M = 1.0
# The first lane after a blind stretch surprises by so many variances and metres. So near to a line, that may just have
# been crossed: vehicles move across at 1 m/s at most, and the camera misses at least half a second. A deviation across
# of the last share of the lane's width leaves the lane open.
SURPRISE, SURPRISE_M, AT_LINE_M, UNSURE = 16.0, 0.5, 0.5, 0.25


@inline
def _from_expected(roads: Roads, lane: int, expected_m: float, seen_m: float) -> float:
    """Return by how much an offset differs from the expected one, or from the same place beside the next lane.

    At a line, the lane that is seen may be either of the two that it parts.
    """
    off = seen_m - expected_m
    side = 1.0 if off < 0.0 else -1.0
    other = roads.graph.left[lane] if off < 0.0 else roads.graph.right[lane]
    width = roads.sides.width_m[lane]
    if other < 0 or abs(side * expected_m - 0.5 * width) > AT_LINE_M:
        return off
    beyond = off + side * 0.5 * (width + roads.sides.width_m[other])
    return beyond if abs(beyond) < abs(off) else off


@inline
def look_again(
    state: Association,
    row: int,
    roads: Roads,
    layer: int,
    heading: float,
    offset_m: float,
    sigma_m: float,
    settling: int,
) -> None:
    """Compare the first lane after a blind stretch with where one was expected.

    Where that was uncertain, or surprises, a neighbour is as likely, and trusted fixes decide. A surprise also makes
    the free filter doubt itself: the way was another one, or the fixes before the blind stretch were wrong.
    """
    best = most_likely(state, row)
    if best < 0:
        return
    place = place_of(state, row, best)
    at = beside(roads.lanes, state.segment[row, best], place.x, place.y, heading)
    across = variance_across(place, at)
    lane = state.lane[row, best]
    width = roads.sides.width_m[lane]
    off = _from_expected(roads, lane, at.offset_m * at.cosine, offset_m * at.cosine)
    surprised = off * off > SURPRISE * (across + sigma_m * sigma_m) and abs(off) > SURPRISE_M
    if not surprised and across <= (UNSURE * width) ** 2:
        return
    state.settling[row] = settling
    count = state.used[row]
    if surprised:
        for h in range(count):
            state.covariance[row, h, 0] += off * off
            state.covariance[row, h, 2] += off * off
        state.free_covariance[row, 0] += off * off
        state.free_covariance[row, 2] += off * off
    for h in range(count):
        ray = Ray(state.position_m[row, h, 0], state.position_m[row, h, 1], cos(heading), sin(heading))
        weight = state.weight[row, h]
        propose_beside(state, row, roads, layer, h, True, ray, weight)
        propose_beside(state, row, roads, layer, h, False, ray, weight)


@inline
def use_camera(
    state: Association,
    row: int,
    roads: Roads,
    layer: int,
    heading: float,
    offset_m: float,
    slope_rad: float,
    sigma_m: float,
) -> bool:
    """Weigh the hypotheses by the lane that the camera sees, propose neighbours, correct across, in bends along.

    Returns whether one of them explains it.
    """
    for h in range(state.used[row]):
        place = place_of(state, row, h)
        at = beside(roads.lanes, state.segment[row, h], place.x, place.y, heading)
        off = offset_m - at.offset_m
        if at.cosine >= MIN_COS and abs(off) > SUSPICIOUS * roads.sides.width_m[state.lane[row, h]]:
            ray = Ray(place.x, place.y, cos(heading), sin(heading))
            propose_beside(state, row, roads, layer, h, off < 0.0, ray, state.weight[row, h] + NEIGHBOUR)
    explained = False
    white = SLOPE_SIGMA * SLOPE_SIGMA
    for h in range(state.used[row]):
        place = place_of(state, row, h)
        at = beside(roads.lanes, state.segment[row, h], place.x, place.y, heading)
        if at.cosine < MIN_COS:
            state.weight[row, h] += LEAST_OFFSET
            continue
        off = offset_m - at.offset_m
        explained = explained or abs(off) <= CONTRADICTION_M
        width = roads.sides.width_m[state.lane[row, h]]
        variance = variance_across(place, at) + sigma_m * sigma_m
        slip = wrap_angle(slope_rad - at.turn_rad)
        bend = at.curvature_per_m
        spread = white + bend * bend * variance_along(place, at)
        state.weight[row, h] += max(-0.5 * off * off / variance, LEAST_OFFSET)
        state.weight[row, h] += max(-0.5 * slip * slip / spread, LEAST_SLOPE)
        if off * off < max(0.25 * width * width, 4.0 * variance):
            correct(state, row, h, at.nx, at.ny, off * at.cosine, sigma_m * sigma_m)
            if abs(bend) > BEND_PER_M:
                correct(state, row, h, bend * at.ny, -bend * at.nx, slip, SLOPE_SAMPLES * white)
    return explained


@inline
def use_heading(state: Association, row: int, roads: Roads, layer: int, heading: float) -> None:
    """Weigh the hypotheses while the camera is blind: by the lane's direction, and by what lies beyond its line."""
    for h in range(state.used[row]):
        place = place_of(state, row, h)
        at = beside(roads.lanes, state.segment[row, h], place.x, place.y, heading)
        beyond = max(abs(at.offset_m) - 0.5 * roads.sides.width_m[state.lane[row, h]], 0.0)
        variance = variance_across(place, at) + EDGE_SIGMA_M * EDGE_SIGMA_M
        cost = -0.5 * (at.turn_rad / HEADING_SIGMA) ** 2 - 0.5 * beyond * beyond / variance
        state.weight[row, h] += max(cost, LEAST_BLIND)
    for h in range(state.used[row]):
        place = place_of(state, row, h)
        at = beside(roads.lanes, state.segment[row, h], place.x, place.y, heading)
        beyond = abs(at.offset_m) - 0.5 * roads.sides.width_m[state.lane[row, h]]
        if beyond > CROSSED_M and at.cosine >= MIN_COS:
            ray = Ray(place.x, place.y, cos(heading), sin(heading))
            propose_beside(state, row, roads, layer, h, at.offset_m > 0.0, ray, state.weight[row, h])
