"""What fits of a lane to the marks of both of its lines have in common."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.birdseye import Marks

# Marks of one dash and one row are not independent: this many count as one.
ALIKE = 4.0
ROUNDS = 3
# Beyond this direction a polynomial of x no longer follows a line well.
STEEPEST = 0.7
# Deviation of a mark across the road: what paint and picture add at any distance, and what a pixel is there.
_NEAR_M, _PIXELS = 0.03, 0.7


class LaneMarks(NamedTuple):
    """The n marks of both lines of a lane, and what is expected of it.

    Attributes:
        marks: of both.
        side: (n,) 1 for the left line, −1 for the right one.
        sigma_m: (n,) deviation of each mark across the road.
        width_m: of the lane.
    """

    marks: Marks
    side: Floats
    sigma_m: Floats
    width_m: float

    @classmethod
    def of(cls, left: Marks, right: Marks, width_m: float, pixel_rad: float) -> "LaneMarks":
        """Return the marks of two lines; `pixel_rad` is the angle that a pixel covers."""
        both = Marks(*(np.concatenate(pair) for pair in zip(left, right, strict=True)))
        side = np.concatenate([np.ones(len(left.x_m)), -np.ones(len(right.x_m))])
        return cls(both, side, np.hypot(_NEAR_M, _PIXELS * pixel_rad * both.x_m), width_m)


class Solved(NamedTuple):
    """A fit of k values: offset, direction and two of the shape, width, by how much the lines run apart, and others.

    Attributes:
        values: (k,) of them.
        covariance: (k, k) of these, where marks deviate as `LaneMarks.sigma_m` says.
        expected: (k,) what they were expected to be beforehand.
        prior: (k,) with these precisions, 0 for none.
        rest_m: (n,) by which marks are off.
        gone: (n,) the same as a share of what makes a mark one of something else, 1 and more.
        spread: of the marks about the fit in units of `LaneMarks.sigma_m`, 1.4826 MAD.
    """

    values: Floats
    covariance: Floats
    expected: Floats
    prior: Floats
    rest_m: Floats
    gone: Floats
    spread: float

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the offset."""
        return float(np.sqrt(max(self.spread, 1.0) ** 2 * self.covariance[0, 0]))


def solve(columns: Floats, weight: Floats, wanted_m: Floats, prior: Floats, pull: Floats) -> tuple[Floats, Floats]:
    """Return k values and their (k, k) covariance by weighted least squares; fits of several have an axis in front.

    Args:
        columns: (n, k) by which each value moves each mark.
        weight: (n,) precisions of the marks.
        wanted_m: (n,) what the values are to explain.
        prior: (k,) precisions of the values.
        pull: (k,) what they are expected to be.

    Raises:
        LinAlgError: marks and priors do not determine the values.

    """
    weighed = np.swapaxes(columns * weight[..., None], -1, -2)
    normal = weighed @ columns + ALIKE * np.diag(prior)
    wanted = (weighed @ wanted_m[..., None])[..., 0] + ALIKE * prior * pull
    inverse: Floats = np.asarray(np.linalg.inv(normal), np.float64)
    return (inverse @ wanted[..., None])[..., 0], ALIKE * inverse


def spread_of(rest_m: Floats, weight: Floats, sigma_m: Floats) -> tuple[Floats, Floats]:
    """Return the spread of marks about a fit, and (n,) how far each is gone, see `Solved`; of several fits, of each."""
    off = np.abs(rest_m) / sigma_m
    ranked = np.sort(np.where(weight > 0.0, off, np.inf), axis=-1)
    count = (weight > 0.0).sum(axis=-1, keepdims=True)
    middle = [np.take_along_axis(ranked, np.maximum(number, 0), axis=-1) for number in ((count - 1) // 2, count // 2)]
    spread = np.where(count > 0, 1.4826 * (0.5 * (middle[0] + middle[1])), 1.0)
    gone: Floats = off / np.maximum(4.0 * spread, 2.0)
    return spread[..., 0], gone


def biweight(gone: Floats) -> Floats:
    """Return (n,) weights of marks by how far they are gone (Tukey's biweight)."""
    weight: Floats = (1.0 - np.minimum(gone, 1.0) ** 2) ** 2
    return weight
