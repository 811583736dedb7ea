"""Figures of an error series with intervals: moments, √structure function, autocorrelation."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from gpsec.core.arrays import Flags, Floats
from gpsec.replay.errors import ErrorSeries, across_along
from gpsec.sensors.smooth import Wander

LAGS_S = (0.1, 1.0, 5.0, 10.0, 30.0, 120.0)
"""Lags of the structure function."""
_REPLICATES, _CONFIDENCE, _SEED = 400, 0.95, 14
# An interval is that of a bootstrap over blocks of so long, at least, and of so many of them, at most.
_BLOCK_S, _MOST_BLOCKS = 5.0, 200
# Fewer blocks than this say nothing of how far a figure may be off.
_FEWEST_BLOCKS = 4


@dataclass(frozen=True)
class LogFigure:
    """A figure of a log with its interval; NaN where the log is too short for one."""

    value: float
    low: float
    high: float


def mean_of(values: Floats, there: Flags, rate_hz: float, finish: Callable[[Floats], Floats]) -> LogFigure:
    """Return `finish` of the mean of those of the (L,) `values` that are there, with a block bootstrap's interval."""
    number = int(there.sum())
    if number == 0:
        return LogFigure(np.nan, np.nan, np.nan)
    value = float(finish(np.array([values[there].mean()]))[0])
    block = max(int(_BLOCK_S * rate_hz), len(values) // _MOST_BLOCKS, 1)
    count = len(values) // block
    if count < _FEWEST_BLOCKS:
        return LogFigure(value, np.nan, np.nan)
    kept = slice(0, count * block)
    sums = np.where(there, values, 0.0)[kept].reshape(count, block).sum(axis=1)
    numbers = there[kept].reshape(count, block).sum(axis=1)
    drawn = np.random.default_rng(_SEED).integers(0, count, (_REPLICATES, count))
    means = sums[drawn].sum(axis=1) / np.maximum(numbers[drawn].sum(axis=1), 1)
    tail = 50.0 * (1.0 - _CONFIDENCE)
    low, high = np.percentile(finish(means), [tail, 100.0 - tail])
    return LogFigure(value, float(low), float(high))


def deviation(series: ErrorSeries, values: Floats) -> LogFigure:
    """Return the standard deviation of (L,) values of a series."""
    there = ~series.missing
    off = values - values[there].mean()
    return mean_of(off * off, there, series.rate_hz, np.sqrt)


def average(series: ErrorSeries, values: Floats) -> LogFigure:
    """Return the mean of (L,) values of a series."""
    return mean_of(values, ~series.missing, series.rate_hz, lambda means: means)


def root_mean_square(series: ErrorSeries, values: Floats) -> LogFigure:
    """Return the root of the mean square of (L,) values of a series."""
    return mean_of(values * values, ~series.missing, series.rate_hz, np.sqrt)


def root_structure(series: ErrorSeries, values: Floats, lag_s: float) -> LogFigure:
    """Return √⟨(x(t + lag) - x(t))²⟩ of (L,) values; NaN where less than two such lags fit into the log."""
    lag = max(round(lag_s * series.rate_hz), 1)
    if len(values) < 2 * lag + 1:
        return LogFigure(np.nan, np.nan, np.nan)
    step = values[lag:] - values[:-lag]
    return mean_of(step * step, _with_those_later(series, lag), series.rate_hz, np.sqrt)


def root_structures(series: ErrorSeries, lag_s: float) -> tuple[LogFigure, LogFigure]:
    """Return the same of errors of fixes, across and along the way as it was before the lag."""
    lag = max(round(lag_s * series.rate_hz), 1)
    if len(series.errors) < 2 * lag + 1:
        return (LogFigure(np.nan, np.nan, np.nan),) * 2
    there = _with_those_later(series, lag)
    step = across_along(series.errors[lag:] - series.errors[:-lag], series.yaw_rad[:-lag])
    across, along = (mean_of(axis * axis, there, series.rate_hz, np.sqrt) for axis in step.T)
    return across, along


def _with_those_later(series: ErrorSeries, lag: int) -> Flags:
    """Return which samples are there, and the one a lag later in the same piece, too."""
    number = np.searchsorted(series.piece, np.arange(len(series.missing)), side="right")
    both: Flags = ~series.missing[lag:] & ~series.missing[:-lag] & (number[lag:] == number[:-lag])
    return both


def autocorrelation(series: ErrorSeries, values: Floats, lag_s: float) -> float:
    """Return the correlation of (L,) values with those a lag later; NaN where there are none."""
    lag = max(round(lag_s * series.rate_hz), 1)
    there = ~series.missing[lag:] & ~series.missing[:-lag]
    if there.sum() < 3:
        return float("nan")
    one, other = values[lag:][there], values[:-lag][there]
    return float(np.corrcoef(one, other)[0, 1]) if one.std() > 0.0 and other.std() > 0.0 else float("nan")


@dataclass(frozen=True)
class WanderFit:
    """A smooth wander and white noise whose structure function is a log's.

    Attributes:
        white_m: standard deviation of the white noise.
        wander: the rest.
        worst_ratio: of √structure, fitted over found, the one farthest from 1.
    """

    white_m: float
    wander: Wander
    worst_ratio: float

    def root_structure_m(self, lag_s: Floats) -> Floats:
        """Return √(2·white² + the wander's structure function) at (n,) lags."""
        found: Floats = np.sqrt(2.0 * self.white_m**2 + self.wander.structure_m2(lag_s))
        return found


def fit_wander(lag_s: Floats, root_structure_m: Floats) -> WanderFit:
    """Return the wander of (n,) values of √structure, least squares in their logarithms; needs four lags or more."""
    lag_s, found = np.asarray(lag_s, float), np.log(np.asarray(root_structure_m, float))

    def made(parameters: Floats) -> WanderFit:
        white, rate, tau, hold = np.exp(parameters)
        return WanderFit(float(white), Wander(float(rate), float(tau), float(hold)), 1.0)

    def off(parameters: Floats) -> Floats:
        left: Floats = np.log(made(parameters).root_structure_m(lag_s)) - found
        return left

    low, high = np.log([1e-5, 1e-5, 0.1, 20.0]), np.log([10.0, 10.0, 60.0, 3600.0])
    begin = np.clip(np.log([0.7 * root_structure_m[0], 0.02, 3.0, 200.0]), low + 1e-6, high - 1e-6)
    best = least_squares(off, begin, bounds=(low, high))
    fitted = made(best.x)
    ratio = np.exp(off(best.x))
    return WanderFit(fitted.white_m, fitted.wander, float(ratio[np.abs(np.log(ratio)).argmax()]))
