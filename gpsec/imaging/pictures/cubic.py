"""The cubic (Eq 1) of a lane's centre, fitted to the marks of both of its lines at once."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.bends import average_over_bends, bends_sharply
from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.fitting import ROUNDS, STEEPEST, LaneMarks, Solved, biweight, solve, spread_of

# Deviations that are expected beforehand, of width, C2 and C3, with what a bend adds to the latter two: a road that
# does not bend does not twist either. They keep the far end of the fit, of which there is little paint, from turning
# the near end.
_WIDTH_M, _BEND, _TWIST = 0.15, (1e-3, 2.0), (2e-6, 0.01)
# While a vehicle nods, its lines seem to run apart: by so much a metre, for a quarter of a degree from 1.3 m above.
_APART = 0.0035 * 3.5


class LineFit(NamedTuple):
    """A lane as fitted.

    Attributes:
        poly: (4,) C0 … C3 of its centre at the rear axle.
        width_m: between the middles of its lines.
        sigma_m: standard deviation of C0.
        spread_m: of the marks about the fit, 1.4826 MAD.
        paint_m: (2,) metres of marks on the left and on the right line.
        far_m: of the marks that were used, the farthest.
        bends: whether the lane bends sharply.
    """

    poly: Floats
    width_m: float
    sigma_m: float
    spread_m: float
    paint_m: tuple[float, float]
    far_m: float
    bends: bool


def fit_lane(left: Marks, right: Marks, start: Floats, width_m: float, pixel_rad: float) -> LineFit | None:
    """Return the fit to the marks of both lines, None where they do not determine one.

    Both lines are parallel to the centre, half a width away along its normal (`start`, (4,), gives the direction in
    the first round). `pixel_rad` is the angle that a pixel covers. Where the lane bends sharply, it may do so from
    a place between axle and marks, or up to one, which no cubic can: there it is averaged over such shapes, too
    (`gpsec.imaging.pictures.bends`).
    """
    lines = LaneMarks.of(left, right, width_m, pixel_rad)
    solved = _solve_cubic(lines, start)
    # Of marks at hardly more than one place the inverse is rounding alone, and a variance may be below zero.
    if solved is None or not np.isfinite(solved.values).all() or not solved.covariance[0, 0] >= 0.0:
        return None
    used = solved.gone < 1.0
    if not used.any():
        return None
    marks = lines.marks
    far_m = float(marks.x_m[used].max())
    paint = tuple(float(marks.row_m[used & (lines.side == way)].sum()) for way in (1.0, -1.0))
    spread_m = 1.4826 * float(np.median(np.abs(solved.rest_m[used])))
    poly, sigma_m = solved.values[:4], solved.sigma_m
    bends = bends_sharply(poly, far_m)
    if bends:
        poly, sigma_m = average_over_bends(lines, solved, far_m)
    return LineFit(poly, float(solved.values[4]), sigma_m, spread_m, (paint[0], paint[1]), far_m, bends)


def _solve_cubic(lines: LaneMarks, start: Floats) -> Solved | None:
    """Return C0 … C3, width and opening; None where marks do not determine them."""
    both, side = lines.marks, lines.side
    trust = both.strength / lines.sigma_m**2
    poly, width = start, lines.width_m
    loose = [fixed + part * abs(start[2]) for fixed, part in (_BEND, _TWIST)]
    prior = np.array([0.0, 0.0, loose[0] ** -2, loose[1] ** -2, _WIDTH_M**-2, _APART**-2])
    pull = np.array([0.0, 0.0, 0.0, 0.0, lines.width_m, 0.0])
    gone = np.zeros(len(side))
    for _ in range(ROUNDS):
        slope = poly[1] + both.x_m * (2.0 * poly[2] + 3.0 * poly[3] * both.x_m)
        norm = np.sqrt(1.0 + slope * slope)
        # A point of a line belongs to that point of the centre that it is beside.
        x = both.x_m + side * 0.5 * width * slope / norm
        weight = trust * biweight(gone) * (np.abs(slope) < STEEPEST)
        columns = np.stack([np.ones_like(x), x, x * x, x**3, 0.5 * side / norm, 0.5 * side * x / norm], axis=1)
        try:
            values, covariance = solve(columns, weight, both.y_m, prior, pull)
        except np.linalg.LinAlgError:
            return None
        poly, width = values[:4], float(values[4])
        rest_m: Floats = both.y_m - columns @ values
        spread, gone = spread_of(rest_m, weight, lines.sigma_m)
    return Solved(values, covariance, pull, prior, rest_m, gone, float(spread))
