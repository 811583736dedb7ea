"""Extreme values: the threshold of a false-alarm rate that is too rare to be counted.

What goes over a high level is distributed as a generalised Pareto distribution, whatever the statistic (Pickands,
Annals of Statistics 3, 1975; peaks over threshold: Davison and Smith, JRSS B 52, 1990). With n excesses over a level u₀
in H hours, of shape ξ and scale σ, there are

    r(u) = (n/H) · (1 + ξ·(u - u₀)/σ)^(-1/ξ)

alarms in an hour over a threshold u. A peak is the largest statistic of a vehicle that is never in alarm: until its
first alarm a vehicle does as in the open loop, so it would raise one at u exactly if its peak is over u.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from gpsec.core.arrays import Floats

# Excesses that a fit needs at least.
FEWEST = 50
REPLICATES = 200
CONFIDENCE = 0.95
_SEED = 20_261_129


@dataclass(frozen=True)
class Tail:
    """A generalised Pareto distribution of what goes over a level.

    Attributes:
        level: u₀.
        per_hour: n/H.
        shape, scale: ξ and σ.
    """

    level: float
    per_hour: float
    shape: float
    scale: float

    def threshold(self, per_hour: float) -> float:
        """Return the threshold over which there are so many alarms in an hour, fewer than `self.per_hour`."""
        probability = per_hour / self.per_hour
        return self.level + float(stats.genpareto.isf(probability, self.shape, scale=self.scale))

    def rate(self, threshold: float) -> float:
        """Return the alarms in an hour over a threshold that is not below the level."""
        return self.per_hour * float(stats.genpareto.sf(threshold - self.level, self.shape, scale=self.scale))


@dataclass(frozen=True)
class Modelled:
    """A threshold, and the interval of the rate that it has: of the number of excesses, and of the fit."""

    threshold: float
    lo: float
    hi: float


def fit_tail(peaks: Floats, hours: float, level: float) -> Tail | None:
    """Return the tail of (n,) peaks over a level, None where fewer than `FEWEST` are over it, or all are equal."""
    excess = peaks[peaks > level] - level
    if len(excess) < FEWEST or np.ptp(excess) == 0.0:
        return None
    shape, _, scale = stats.genpareto.fit(excess, 0.0, floc=0.0, scale=float(excess.mean()))
    return Tail(level, len(excess) / hours, float(shape), float(scale))


def modelled_thresholds(peaks: Floats, hours: float, level: float, rates: list[float]) -> list[Modelled] | None:
    """Return a threshold for each rate (alarms in an hour); None where there is too little to fit.

    The interval is a parametric bootstrap: the number of excesses is drawn from a Poisson distribution, they themselves
    from the fit, and the tail is fitted anew. It holds the model to be right, which counting cannot prove out there.
    """
    tail = fit_tail(peaks, hours, level)
    if tail is None:
        return None
    thresholds = [tail.threshold(rate) for rate in rates]
    generator = np.random.default_rng(_SEED)
    drawn: list[list[float]] = []
    while len(drawn) < REPLICATES:
        count = max(int(generator.poisson(tail.per_hour * hours)), FEWEST)
        again = stats.genpareto.rvs(tail.shape, scale=tail.scale, size=count, random_state=generator)
        other = fit_tail(again, hours, 0.0)
        if other is not None:
            drawn.append([other.rate(threshold - level) for threshold in thresholds])
    low, high = np.quantile(np.array(drawn), [0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE], axis=0)
    return [Modelled(threshold, float(lo), float(hi)) for threshold, lo, hi in zip(thresholds, low, high, strict=True)]


def counted_interval(events: int, hours: float) -> tuple[float, float]:
    """Return the exact interval of a rate of which so many events were counted (Garwood, Biometrika 28, 1936)."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = float(stats.chi2.ppf(tail, 2 * events)) / 2.0 if events else 0.0
    return low / hours, float(stats.chi2.isf(tail, 2 * events + 2)) / 2.0 / hours
