"""Causal tracking of the lane: a few hypotheses a track, moved by odometer and heading, weighed by the camera.

After the start a fix moves a hypothesis along its lane only, never across, and only while the free filter trusts fixes.
So a spoofed fix cannot move a vehicle into another lane. See docs/association.md for the rules and what was measured.
"""

from math import atan, ceil, cos, sin

from gpsec.association import free
from gpsec.association.evidence import look_again, use_camera, use_heading
from gpsec.association.free import Motion, motion_of
from gpsec.association.geometry import propose_around, walk_on
from gpsec.association.state import Association, correct, drop, most_likely, place_of, propose
from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.hdmap.arrays import Roads
from gpsec.hdmap.search import Ray
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Lanes this near to the first fix are looked at, and fixes are used across the lane for so long after it.
START_M, SETTLING_S = 4.0, 3.0
# The free filter must have accepted so many fixes in turn before one moves a hypothesis.
TRUSTED = 20
# Less likely hypotheses are dropped; another lane within the second one of the best makes the lane unknown.
DROP, AS_LIKELY = -25.0, -3.0
# So many samples in turn that no hypothesis explains contradict them all.
STRIKES = 15
# The first lane after so long without one is looked at with care.
BLIND_S = 0.5
# The slow error of fixes lasts: along the lane, each counts a tenth.
BIAS_SAMPLES = 10.0


@kernel
def associate(
    rows: Ints,
    step_s: float,
    roads: Roads,
    noise: FilterNoise[Floats],
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
    state: Association,
) -> None:
    """Take one step with the track rows `rows`: set which lane each believes to be on."""
    for row in rows:
        v = tracks.vehicle[row]
        q = vehicles.profile[v]
        layer = roads.layer[q]
        heading = seen.heading_rad[v]
        x, y = tracks.fix_m[row, 0], tracks.fix_m[row, 1]
        tracks.unmatched[row] = False
        if not state.started[row]:
            if not tracks.fix_valid[row]:
                continue
            free.start_free(state, row, noise, q, x, y)
            state.started[row] = True
            _begin(state, row, roads, noise, q, Ray(x, y, cos(heading), sin(heading)))
        else:
            motion = motion_of(seen.speed_mps[v], seen.yaw_rate_rps[v] * step_s, heading, step_s)
            free.predict(state, row, noise, q, motion, step_s)
            _move(state, row, noise, q, motion, step_s)
            _go_on(state, row, roads, layer)
            if tracks.fix_valid[row]:
                free.take_fix(state, row, noise, q, x, y)
                _use_fix(state, row, roads, noise, q, x, y)
        if seen.camera_valid[v]:
            offset_m, sigma_m = -seen.lane_poly[v, 0], seen.camera_sigma_m[v]
            if state.blind_s[row] > BLIND_S:
                settling = ceil(SETTLING_S / noise.gnss_period_s[q])
                look_again(state, row, roads, layer, heading, offset_m, sigma_m, settling)
            state.blind_s[row] = 0.0
            slope_rad = atan(seen.lane_poly[v, 1])
            tracks.unmatched[row] = not use_camera(state, row, roads, layer, heading, offset_m, slope_rad, sigma_m)
        else:
            state.blind_s[row] += step_s
            use_heading(state, row, roads, layer, heading)
        _settle(state, row, roads, noise, q, heading, tracks)


@inline
def _begin(state: Association, row: int, roads: Roads, noise: FilterNoise[Floats], profile: int, ray: Ray) -> None:
    """Begin anew with the lanes around a position."""
    state.used[row] = 0
    state.strikes[row] = 0
    state.settling[row] = ceil(SETTLING_S / noise.gnss_period_s[profile])
    variance = noise.gnss_white_m[profile] ** 2 + noise.gnss_bias_m[profile] ** 2
    reach_m = 2.0 * START_M if state.begun[row] else START_M
    propose_around(state, row, roads, roads.layer[profile], ray, variance, reach_m)


@inline
def _move(
    state: Association, row: int, noise: FilterNoise[Floats], profile: int, motion: Motion, step_s: float
) -> None:
    """Move every hypothesis by odometer and heading."""
    way = motion.way_m / (1.0 + state.free_scale[row])
    dx, dy = way * motion.dx, way * motion.dy
    white = noise.odometer_white_mps[profile] * step_s
    speed2 = motion.speed_mps * motion.speed_mps * step_s * LASTING_ERROR_S
    along = white * white + max(state.free_covariance[row, 5], 0.0) * speed2
    across = noise.heading_rad[profile] ** 2 * speed2
    xx = along * motion.c * motion.c + across * motion.s * motion.s
    xy = (along - across) * motion.c * motion.s
    yy = along * motion.s * motion.s + across * motion.c * motion.c
    for h in range(state.used[row]):
        state.position_m[row, h, 0] += dx
        state.position_m[row, h, 1] += dy
        state.covariance[row, h, 0] += xx
        state.covariance[row, h, 1] += xy
        state.covariance[row, h, 2] += yy


@inline
def _go_on(state: Association, row: int, roads: Roads, layer: int) -> None:
    """Let every hypothesis pass along its lane and, past its end, into each of the lanes that it leads to."""
    lanes, graph = roads.lanes, roads.graph
    h = 0
    hops = 0
    while h < state.used[row]:
        lane = state.lane[row, h]
        place = place_of(state, row, h)
        segment, passed = walk_on(roads, layer, lane, state.segment[row, h], place.x, place.y)
        state.segment[row, h] = segment
        if not passed or graph.after_count[lane] == 0 or hops >= 4 * len(state.lane[row]):
            h += 1
            continue
        hops += 1
        weight = state.weight[row, h]
        # The last one takes its place, and what it leads to is looked at in its turn: a lane may be short.
        drop(state, row, h)
        for k in range(graph.after_first[lane], graph.after_first[lane] + graph.after_count[lane]):
            after = graph.after_lane[k]
            propose(state, row, after, lanes.first[layer, after], place, weight)


@inline
def _use_fix(
    state: Association, row: int, roads: Roads, noise: FilterNoise[Floats], profile: int, x: float, y: float
) -> None:
    """Correct along the lane, and across while the lane is being settled on, where fixes are trusted."""
    if state.accepted[row] < (TRUSTED if state.begun[row] else 1):
        return
    settling = state.settling[row] > 0
    if settling:
        state.settling[row] -= 1
        state.begun[row] = state.begun[row] or state.settling[row] == 0
    lanes = roads.lanes
    variance = free.white_variance(state, row, noise, profile) + BIAS_SAMPLES * noise.gnss_bias_m[profile] ** 2
    for h in range(state.used[row]):
        segment = state.segment[row, h]
        tx, ty = lanes.dx[segment], lanes.dy[segment]
        ex, ey = x - state.position_m[row, h, 0], y - state.position_m[row, h, 1]
        correct(state, row, h, tx, ty, ex * tx + ey * ty, variance)
        if settling:
            ex, ey = x - state.position_m[row, h, 0], y - state.position_m[row, h, 1]
            correct(state, row, h, -ty, tx, ey * tx - ex * ty, variance)


@inline
def _settle(
    state: Association,
    row: int,
    roads: Roads,
    noise: FilterNoise[Floats],
    profile: int,
    heading: float,
    tracks: Tracks,
) -> None:
    """Choose the best, drop what is too unlikely, and begin anew where everything is contradicted."""
    best = most_likely(state, row)
    ray = Ray(state.free_m[row, 0], state.free_m[row, 1], cos(heading), sin(heading))
    if best < 0:
        tracks.lane[row] = -1
        tracks.lane_known[row] = False
        if state.started[row]:
            _begin(state, row, roads, noise, profile, ray)
        return
    lane = state.lane[row, best]
    top = state.weight[row, best]
    if tracks.unmatched[row]:
        state.strikes[row] += 1
        if state.strikes[row] >= STRIKES:
            ray = Ray(state.position_m[row, best, 0], state.position_m[row, best, 1], ray.ux, ray.uy)
    else:
        state.strikes[row] = 0
    known = True
    h = 0
    while h < state.used[row]:
        state.weight[row, h] -= top
        if state.weight[row, h] < DROP:
            drop(state, row, h)
            continue
        if state.lane[row, h] != lane and state.weight[row, h] > AS_LIKELY:
            known = False
        h += 1
    tracks.lane[row] = lane
    tracks.lane_known[row] = known
    if state.strikes[row] >= STRIKES:
        _begin(state, row, roads, noise, profile, ray)
