"""What is computed from counts and sums: pure functions on arrays of any shape.

A figure can be undefined (the precision of a detector that never raised an alarm); it then has the value 0 and is
not `known`, and its cell in a table is empty.
"""

from math import log
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats

Numbers = NDArray[np.floating[Any]] | NDArray[np.integer[Any]]


class Figures(NamedTuple):
    """Values (…,) and whether each is defined."""

    value: Floats
    known: Flags


def ratio(numerator: Numbers, denominator: Numbers) -> Figures:
    """Return numerator / denominator, undefined where the denominator is 0."""
    over = np.asarray(denominator, np.float64)
    known = over > 0.0
    return Figures(np.divide(numerator, over, out=np.zeros_like(over), where=known), known)


def precision(tp: Numbers, fp: Numbers, fn: Numbers) -> Figures:
    """Return TP / (TP + FP), the share of alarmed samples that were attacked; undefined without attacked samples.

    Where none could be scored (jamming leaves no fix), every alarm would count against the detector.
    """
    score = ratio(tp, tp + fp)
    known = score.known & (np.asarray(tp + fn, np.float64) > 0.0)
    return Figures(np.where(known, score.value, 0.0), known)


def recall(tp: Numbers, fn: Numbers) -> Figures:
    """Return TP / (TP + FN): the share of attacked samples that were alarmed."""
    return ratio(tp, tp + fn)


def f1(tp: Numbers, fp: Numbers, fn: Numbers) -> Figures:
    """Return 2 TP / (2 TP + FP + FN), the harmonic mean of both; undefined without attacked samples."""
    score = ratio(2 * tp, 2 * tp + fp + fn)
    known = np.asarray(tp + fn, np.float64) > 0.0
    return Figures(np.where(known, score.value, 0.0), known)


def rmse(squared: Floats, samples: Numbers) -> Figures:
    """Return the root of the mean squared error, pooled: √(Σ e² / number of samples)."""
    mean = ratio(squared, samples)
    return Figures(np.sqrt(mean.value), mean.known)


def quantiles(values: Floats, known: Flags, share: float) -> Figures:
    """Return a quantile over the first axis of (B, …) values, of those that are known."""
    value = np.zeros(values.shape[1:])
    somewhere = np.asarray(known.any(axis=0))
    everywhere = somewhere & known.all(axis=0)
    if everywhere.any():
        value[everywhere] = np.quantile(values[:, everywhere], share, axis=0)
    for index in map(tuple, np.argwhere(somewhere & ~everywhere)):  # also of a single figure, where it is ()
        cell = (slice(None), *index)
        value[index] = np.quantile(values[cell][known[cell]], share)
    return Figures(value, somewhere)


def percentile_interval(replicates: Figures, confidence: float) -> tuple[Figures, Figures]:
    """Return lower and upper bounds from (B, …) bootstrap replicates; undefined replicates are left out."""
    tail = 0.5 * (1.0 - confidence)
    return quantiles(*replicates, tail), quantiles(*replicates, 1.0 - tail)


def wilson_interval(successes: Numbers, trials: Numbers, confidence: float) -> tuple[Figures, Figures]:
    """Return Wilson's score interval of a share (Wilson, JASA 1927): never empty at 0 or 1, as a bootstrap's is."""
    z = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    share, known = ratio(successes, trials)
    n = np.maximum(np.asarray(trials, np.float64), 1.0)
    centre = (share + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z / (1.0 + z * z / n) * np.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    low = np.where(known & (share > 0.0), np.maximum(centre - half, 0.0), 0.0)
    high = np.where(known, np.where(share < 1.0, np.minimum(centre + half, 1.0), 1.0), 0.0)
    return Figures(low, known), Figures(high, known)


def poisson_interval(count: Numbers, exposure: Numbers, confidence: float) -> tuple[Figures, Figures]:
    """Return the exact bounds of the rate of a Poisson count (Garwood, Biometrika 1936); undefined without exposure."""
    from scipy.stats import chi2

    tail, twice = 0.5 * (1.0 - confidence), 2.0 * np.asarray(count, np.float64)
    low = np.where(twice > 0.0, 0.5 * chi2.ppf(tail, np.maximum(twice, 1.0)), 0.0)
    return ratio(low, exposure), ratio(0.5 * chi2.ppf(1.0 - tail, twice + 2.0), exposure)


def poisson_bound_of_none(exposure: Numbers, confidence: float) -> Figures:
    """Return the upper bound of a rate of which `exposure` has seen no event: exact, for a Poisson count of 0.

    It is the upper end of the two-sided interval of Garwood (Biometrika 1936), the rate at which no event at all has
    the probability (1 − confidence) / 2; the lower end is 0.
    """
    return ratio(np.full(np.shape(exposure), -log(0.5 * (1.0 - confidence))), exposure)
