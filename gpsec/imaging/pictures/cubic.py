"""The cubic (Eq 1) of a lane's centre, fitted to the marks of both of its lines at once."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.birdseye import Marks

# Deviations that are expected beforehand, of width, C2 and C3, with what a bend adds to the latter two: a road that
# does not bend does not twist either. They keep the far end of the fit, of which there is little paint, from turning
# the near end.
_WIDTH_M, _BEND, _TWIST = 0.15, (1e-3, 2.0), (2e-6, 0.01)
# While a vehicle nods, its lines seem to run apart: by so much a metre, for a quarter of a degree from 1.3 m above.
_APART = 0.0035 * 3.5
# Deviation of a mark across the road: what paint and picture add at any distance, and what a pixel is there.
_NEAR_M, _PIXELS = 0.03, 0.7
# Marks of one dash and one row are not independent: this many count as one.
_ALIKE = 4.0
_ROUNDS = 3
# Beyond this direction a polynomial of x no longer follows a line well.
_STEEPEST = 0.7


class LineFit(NamedTuple):
    """A lane as fitted.

    Attributes:
        poly: (4,) C0 … C3 of its centre at the rear axle.
        width_m: between the middles of its lines.
        sigma_m: standard deviation of C0.
        spread_m: of the marks about the fit, 1.4826 MAD.
        paint_m: (2,) metres of marks on the left and on the right line.
        far_m: of the marks that were used, the farthest.
    """

    poly: Floats
    width_m: float
    sigma_m: float
    spread_m: float
    paint_m: tuple[float, float]
    far_m: float


def fit_lane(left: Marks, right: Marks, start: Floats, width_m: float, pixel_rad: float) -> LineFit | None:
    """Return the fit to the marks of both lines, None where they do not determine one.

    Both lines are parallel to the centre, half a width away along its normal (`start`, (4,), gives the direction in
    the first round). `pixel_rad` is the angle that a pixel covers.
    """
    both = Marks(*(np.concatenate(pair) for pair in zip(left, right, strict=True)))
    side = np.concatenate([np.ones(len(left.x_m)), -np.ones(len(right.x_m))])
    sigma = np.hypot(_NEAR_M, _PIXELS * pixel_rad * both.x_m)
    trust = both.strength / sigma**2
    poly, width = start, width_m
    bent = abs(start[2])
    loose = [fixed + part * bent for fixed, part in (_BEND, _TWIST)]
    prior = np.array([0.0, 0.0, loose[0] ** -2, loose[1] ** -2, _WIDTH_M**-2, _APART**-2])
    gone = np.zeros(len(side))
    for _ in range(_ROUNDS):
        slope = poly[1] + both.x_m * (2.0 * poly[2] + 3.0 * poly[3] * both.x_m)
        norm = np.sqrt(1.0 + slope * slope)
        # A point of a line belongs to that point of the centre that it is beside.
        x = both.x_m + side * 0.5 * width * slope / norm
        weight = trust * (1.0 - np.minimum(gone, 1.0) ** 2) ** 2 * (np.abs(slope) < _STEEPEST)
        columns = np.stack([np.ones_like(x), x, x * x, x**3, 0.5 * side / norm, 0.5 * side * x / norm], axis=1)
        normal = (columns * weight[:, None]).T @ columns
        wanted = (columns * weight[:, None]).T @ both.y_m
        normal[np.diag_indices(6)] += _ALIKE * prior
        wanted[4] += _ALIKE * prior[4] * width_m
        try:
            inverse = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            return None
        solved = inverse @ wanted
        poly, width = solved[:4], float(solved[4])
        rest = both.y_m - columns @ solved
        spread = 1.4826 * float(np.median(np.abs(rest[weight > 0.0] / sigma[weight > 0.0]))) if weight.any() else 1.0
        gone = np.abs(rest) / (sigma * max(4.0 * spread, 2.0))
    used = gone < 1.0
    # Of marks at hardly more than one place the inverse is rounding alone, and a variance may be below zero.
    if not np.isfinite(solved).all() or not used.any() or not inverse[0, 0] >= 0.0:
        return None
    inflation = max(spread, 1.0) ** 2 * _ALIKE
    paint = tuple(float(both.row_m[used & (side == way)].sum()) for way in (1.0, -1.0))
    spread_m = 1.4826 * float(np.median(np.abs(rest[used])))
    sigma_m = float(np.sqrt(inflation * inverse[0, 0]))
    return LineFit(poly, width, sigma_m, spread_m, (paint[0], paint[1]), float(both.x_m[used].max()))
