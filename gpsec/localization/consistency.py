"""Is a filter as far off as it says? Normalised errors and innovations, and the bounds that they should keep.

The normalised estimation error squared eᵀ P⁻¹ e (NEES) and the normalised innovation squared νᵀ S⁻¹ ν (NIS) of a
consistent filter are chi-square distributed, with as many degrees of freedom as e or ν has parts (Bar-Shalom, Li and
Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 5.4). Larger means over-confident.
"""

from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist

import numpy as np

from gpsec.core.arrays import Floats, Ints


@dataclass(frozen=True)
class Consistency:
    """The mean of a normalised square over vehicles and time, and what it should be.

    Attributes:
        mean: over vehicles, of each vehicle's mean over time.
        lo, hi: interval of that mean, from how much vehicles differ.
        freedom: its expectation, the degrees of freedom.
        bound_lo, bound_hi: chi-square bounds of the mean, if each vehicle gave a single independent sample.
        vehicles: their number.

    """

    mean: float
    lo: float
    hi: float
    freedom: int
    bound_lo: float
    bound_hi: float
    vehicles: int

    @property
    def consistent(self) -> bool:
        """Whether the mean is within its bounds; a mean error, which has none, whether its interval holds 0.

        An interval that holds the expectation is no proof: one vehicle that is lost makes it as wide as one likes.
        """
        if self.freedom == 0:
            return self.lo <= 0.0 <= self.hi
        return self.bound_lo <= self.mean <= self.bound_hi


def nees(error: Floats, covariance: Floats) -> Floats:
    """Return the (n,) normalised squares of (n, d) errors with (n, d, d) covariances."""
    solved = np.linalg.solve(covariance, error[..., np.newaxis])[..., 0]
    return np.asarray((error * solved).sum(axis=-1))


def nis(innovation: Floats) -> Floats:
    """Return the (n,) normalised squares of (n, d) innovations that are normalised one by one (`Branches`)."""
    return np.asarray((innovation**2).sum(axis=-1))


def along_and_across(error: Floats, yaw_rad: Floats) -> Floats:
    """Return (n, 2) errors in the net's frame as along and across the direction `yaw_rad`, ahead and left positive."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.stack([c * error[:, 0] + s * error[:, 1], c * error[:, 1] - s * error[:, 0]], axis=-1)


def chi_square_quantile(probability: float, freedom: float) -> float:
    """Return the quantile of a chi-square distribution by Wilson and Hilferty (1931), good to 1 % from 20 degrees on.

    That of no degree of freedom is 0: it serves for plain means, whose expectation is 0.
    """
    if freedom == 0.0:
        return 0.0
    spread = 2.0 / (9.0 * freedom)
    z = NormalDist().inv_cdf(probability)
    return float(freedom * (1.0 - spread + z * sqrt(spread)) ** 3)


def consistency(squares: Floats, vehicle: Ints, freedom: int, confidence: float = 0.95) -> Consistency:
    """Sum up (n,) normalised squares of the vehicles (n,) `vehicle`.

    The samples of one vehicle are correlated (its slow errors last for minutes), so that many of them are worth little
    more than one: the interval comes from the spread of the vehicles' means.

    Raises:
        ValueError: there are fewer than two vehicles.

    """
    _, number = np.unique(vehicle, return_inverse=True)
    count = np.bincount(number)
    if len(count) < 2:
        raise ValueError(f"expected samples of two vehicles or more, found {len(count)}")
    means = np.bincount(number, weights=squares) / count
    mean = float(means.mean())
    tail = (1.0 - confidence) / 2.0
    half = NormalDist().inv_cdf(1.0 - tail) * float(means.std(ddof=1)) / sqrt(len(means))
    total = len(means) * freedom
    return Consistency(
        mean=mean,
        lo=mean - half,
        hi=mean + half,
        freedom=freedom,
        bound_lo=chi_square_quantile(tail, total) / len(means),
        bound_hi=chi_square_quantile(1.0 - tail, total) / len(means),
        vehicles=len(means),
    )
