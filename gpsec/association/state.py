"""What a track keeps of the lanes that it may be on."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline
from gpsec.core.tables import blank

# Lanes that a track may be on, at once.
HYPOTHESES = 6


class Association(NamedTuple):
    """The lane hypotheses of M tracks, and a filter that knows no lane.

    A covariance of two is kept as (east-east, east-north, north-north); that of the free filter as the lower triangle
    of east, north and scale.

    Attributes:
        started: (M,) there has been a fix.
        begun: (M,) the first fixes have been settled on; from then on a fix must be trusted to be used.
        settling: (M,) for so many more trusted fixes they are used across the lane, too.
        blind_s: (M,) time since the camera saw a lane.
        used: (M,) hypotheses in use, the first ones.
        lane, segment: (M, H) of each hypothesis; the segment of the vehicle's own map that it is beside.
        position_m: (M, H, 2) of the rear axle.
        covariance: (M, H, 3) of the position, in m².
        weight: (M, H) logarithm of its likelihood over that of the best.
        strikes: (M,) samples of the camera in turn that were unmatched.
        free_m: (M, 2) position of the free filter: odometer, heading and the fixes that it accepts.
        free_scale: (M,) scale error of the odometer that it has learnt.
        free_covariance: (M, 6) of both.
        accepted: (M,) fixes that it has accepted in turn; -1 where it refused the last one.
        left_over_m: (M, 2) by how much the last fix differs from the free position after it.
        noise: (M,) logarithm of the white variance of fixes, as learnt, over that of the data sheet.
    """

    started: Flags = blank(False)
    begun: Flags = blank(False)
    settling: Ints = blank(0)
    blind_s: Floats = blank(0.0)
    used: Ints = blank(0)
    lane: Ints = blank(-1, HYPOTHESES)
    segment: Ints = blank(-1, HYPOTHESES)
    position_m: Floats = blank(0.0, HYPOTHESES, 2)
    covariance: Floats = blank(0.0, HYPOTHESES, 3)
    weight: Floats = blank(0.0, HYPOTHESES)
    strikes: Ints = blank(0)
    free_m: Floats = blank(0.0, 2)
    free_scale: Floats = blank(0.0)
    free_covariance: Floats = blank(0.0, 6)
    accepted: Ints = blank(0)
    left_over_m: Floats = blank(0.0, 2)
    noise: Floats = blank(0.0)


class Place(NamedTuple):
    """Where a hypothesis is: position (m) and the covariance of it (m²)."""

    x: float
    y: float
    xx: float
    xy: float
    yy: float


@inline
def place_of(state: Association, row: int, h: int) -> Place:
    """Return where a hypothesis is."""
    P = state.covariance[row, h]
    return Place(state.position_m[row, h, 0], state.position_m[row, h, 1], P[0], P[1], P[2])


@inline
def propose(state: Association, row: int, lane: int, segment: int, place: Place, weight: float) -> None:
    """Add a hypothesis, unless there is a better one of its lane; where there is no room, it takes the worst one's."""
    at = -1
    for h in range(state.used[row]):
        if state.lane[row, h] == lane:
            at = h
    if at < 0 and state.used[row] < HYPOTHESES:
        at = state.used[row]
        state.used[row] += 1
    else:
        if at < 0:
            at = 0
            for h in range(HYPOTHESES):
                if state.weight[row, h] < state.weight[row, at]:
                    at = h
        if state.weight[row, at] >= weight:
            return
    state.lane[row, at] = lane
    state.segment[row, at] = segment
    state.position_m[row, at, 0], state.position_m[row, at, 1] = place.x, place.y
    P = state.covariance[row, at]
    P[0], P[1], P[2] = place.xx, place.xy, place.yy
    state.weight[row, at] = weight


@inline
def most_likely(state: Association, row: int) -> int:
    """Return the hypothesis with the largest weight, -1 where there is none."""
    best = -1
    for h in range(state.used[row]):
        if best < 0 or state.weight[row, h] > state.weight[row, best]:
            best = h
    return best


@inline
def drop(state: Association, row: int, h: int) -> None:
    """Take a hypothesis away; the last one takes its place."""
    last = state.used[row] - 1
    if h != last:
        state.lane[row, h] = state.lane[row, last]
        state.segment[row, h] = state.segment[row, last]
        state.weight[row, h] = state.weight[row, last]
        for i in range(2):
            state.position_m[row, h, i] = state.position_m[row, last, i]
        for i in range(3):
            state.covariance[row, h, i] = state.covariance[row, last, i]
    state.used[row] = last


@inline
def correct(state: Association, row: int, h: int, hx: float, hy: float, innovation: float, variance: float) -> None:
    """Correct a hypothesis by the innovation of what was seen of hx·east + hy·north, with noise of that variance."""
    P = state.covariance[row, h]
    px, py = P[0] * hx + P[1] * hy, P[1] * hx + P[2] * hy
    S = hx * px + hy * py + variance
    kx, ky = px / S, py / S
    state.position_m[row, h, 0] += kx * innovation
    state.position_m[row, h, 1] += ky * innovation
    P[0] -= kx * px
    P[1] -= kx * py
    P[2] -= ky * py
