"""A lane that begins or ends to bend at a place ahead: arcs that no cubic of x can follow from the axle on.

A cubic that is carried back from marks on an arc to an axle on the straight before it is off by half a metre. So where
a lane bends sharply, what it is at the axle is averaged over the cubic and over pairs of arcs that meet at places
ahead, each weighted by how well it explains the marks and how little it has to assume (Bayesian model averaging,
evidence by Laplace's approximation). The standard deviation has what they differ by: marks often cannot tell where a
bend begins.
"""

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.fitting import ALIKE, ROUNDS, STEEPEST, LaneMarks, Solved, biweight, solve, spread_of

# A lane bends sharply from this curvature on (1/m), at the axle or at its far end.
_SHARP = 1.0 / 250.0
# Places (m ahead of the rear axle) about which the curvature may change, give or take a metre, and how far beyond marks
# must reach to tell of it.
_PLACES_M, _ABOUT_M, _BEYOND_M = (2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 21.0, 24.0, 28.0), 1.0, 4.0
# No lane bends more sharply (1/m), whatever a step of the solution says.
_SHARPEST = 0.5
# Deviations that are expected: of the direction of a vehicle that drives along its lane, and of curvatures (1/m).
_ALONG, _CURVATURE = 0.05, 1.0 / 25.0
# So far ahead a cubic is to be where two arcs are, so that a lane that is moved on with the vehicle bends as they do.
_AHEAD_M = 15.0
# Points of a curve are so far apart, and so often the foot of a mark on it is looked for, from the one before.
_EVERY_M, _FEET = 0.5, 2


def bends_sharply(poly: Floats, far_m: float) -> bool:
    """Return whether a cubic (4,) of marks up to `far_m` bends so much that it may be none.

    So it may where it leads aside by more than a vehicle drives askew: the lane may bend nearer than the first marks.
    """
    here = 2.0 * poly[2]
    bend = max(abs(here), abs(here + 6.0 * poly[3] * far_m))
    return bool(bend > _SHARP or abs(poly[1]) > 2.0 * _ALONG)


def average_over_bends(lines: LaneMarks, cubic: Solved, far_m: float) -> tuple[Floats, float]:
    """Return (4,) C0 … C3 at the axle and the standard deviation of C0, given the fit of a cubic up to `far_m`."""
    places_m = np.array([place_m for place_m in _PLACES_M if place_m + _BEYOND_M <= far_m])
    bent = _solve_bent(lines, cubic, places_m) if len(places_m) else []
    shapes = [cubic, *bent]
    noise = max(1.0, min(solved.spread for solved in shapes))
    evidence = np.array([_log_evidence(lines, solved, noise) for solved in shapes])
    weight = np.exp(evidence - evidence.max())
    weight /= weight.sum()
    polys = np.array([cubic.values[:4], *(_at_axle(solved.values) for solved in bent)])
    poly = weight @ polys
    variance = np.array([solved.sigma_m**2 for solved in shapes]) + (polys[:, 0] - poly[0]) ** 2
    return poly, float(np.sqrt(weight @ variance))


def _solve_bent(lines: LaneMarks, cubic: Solved, places_m: Floats) -> list[Solved]:
    """Return pairs of arcs that meet about each of (p,) places, by Gauss and Newton; those that marks determine.

    Their values are offset, direction, curvature, by how much that changes, width, opening, and where it changes.
    """
    count, trust, half = len(places_m), lines.marks.strength / lines.sigma_m**2, 0.5 * lines.side
    expected = np.tile([0.0, 0.0, 0.0, 0.0, lines.width_m, 0.0, 0.0], (count, 1))
    expected[:, 6] = places_m
    prior = np.array([0.0, _ALONG**-2, _CURVATURE**-2, _CURVATURE**-2, *cubic.prior[4:], _ABOUT_M**-2])
    offset, slope, bend = cubic.values[:3]
    values = np.tile([offset, np.arctan(slope), 2.0 * bend, 0.0, *cubic.values[4:], 0.0], (count, 1))
    values[:, 6] = places_m
    gone = np.zeros((count, len(trust)))
    at_m = np.tile(lines.marks.x_m, (count, 1))
    for _ in range(ROUNDS + 1):
        at_m, off_m, turn = _beside(values, at_m, lines.marks)
        weight = trust * biweight(gone) * (np.abs(turn) < STEEPEST)
        beyond_m = np.maximum(at_m - values[:, 6:], 0.0)
        halves = np.broadcast_to(half, at_m.shape)
        shape = np.cos(turn), at_m, 0.5 * at_m**2, 0.5 * beyond_m**2
        columns = np.stack([*shape, halves, half * at_m, -values[:, 3:4] * beyond_m], axis=-1)
        rest_m = off_m - half * (values[:, 4:5] + values[:, 5:6] * at_m)
        spread, gone = spread_of(rest_m, weight, lines.sigma_m)
        try:
            step, covariance = solve(columns, weight, rest_m, prior, expected - values)
        except np.linalg.LinAlgError:
            return []
        values = values + step
        values[:, 2:4] = np.clip(values[:, 2:4], -_SHARPEST, _SHARPEST)
    return [
        Solved(values[at], covariance[at], expected[at], prior, rest_m[at], gone[at], float(spread[at]))
        for at in range(count)
        if np.isfinite(values[at]).all() and covariance[at, 0, 0] >= 0.0
    ]


def _beside(values: Floats, at_m: Floats, marks: Marks) -> tuple[Floats, Floats, Floats]:
    """Return where on p curves n marks are beside, how far to the left of that they are, and the directions there.

    All are (p, n), and so is `at_m`, where they were before; `values` are (p, 7).
    """
    start, bend, change, place_m = (values[:, [number]] for number in (1, 2, 3, 6))
    way_m = np.arange(0.0, 1.5 * float(marks.x_m.max()) + 2.0 * _EVERY_M, _EVERY_M)
    middle_m = way_m[:-1] + 0.5 * _EVERY_M
    turn = start + bend * middle_m + change * np.maximum(middle_m - place_m, 0.0)
    curve = np.zeros((len(values), len(way_m)), np.complex128)
    curve[:, 0] = 1j * values[:, 0]
    curve[:, 1:] = curve[:, :1] + np.cumsum(np.exp(1j * turn), axis=1) * _EVERY_M
    for _ in range(_FEET):
        number = np.clip((at_m / _EVERY_M).astype(np.int64), 0, len(way_m) - 2)
        there = start + bend * at_m + change * np.maximum(at_m - place_m, 0.0)
        before, after = (np.take_along_axis(curve, number + more, axis=1) for more in (0, 1))
        away = marks.x_m + 1j * marks.y_m - before - (after - before) * (at_m / _EVERY_M - number)
        turned = away * np.exp(-1j * there)
        at_m = np.clip(at_m + turned.real, 0.0, way_m[-1])
    return at_m, turned.imag, there


def _at_axle(values: Floats) -> Floats:
    """Return (4,) C0 … C3 (Eq 1): the Taylor series of the first arc, and a C3 that meets the second some way ahead."""
    slope = np.tan(values[1])
    later = 0.5 * values[3] * max(_AHEAD_M - values[6], 0.0) ** 2 / _AHEAD_M**3
    steeper = (1.0 + slope * slope) ** 1.5
    return np.array([values[0], slope, 0.5 * values[2] * steeper, later * steeper])


def _log_evidence(lines: LaneMarks, solved: Solved, noise: float) -> float:
    """Return the logarithm of the marginal likelihood of a shape, but for what all shapes have in common."""
    off = np.minimum(np.abs(solved.rest_m / lines.sigma_m) / noise, 4.0)
    misfit = float((lines.marks.strength * off * off).sum()) / ALIKE
    prior = np.array([_ALONG**-2, *solved.prior[2:]])
    away = (solved.values - solved.expected)[1:]
    assumed = float(prior @ (away * away))
    volume = float(np.linalg.slogdet(solved.covariance * noise**2)[1]) + float(np.log(prior).sum())
    return 0.5 * (volume - misfit - assumed)
