"""Learns how coloured the benign residual is: the coefficients that whiten it for CUSUM."""

from collections.abc import Sequence
from math import exp, inf, log

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.detection.alarm import GAP_S, steps_in
from gpsec.detection.cusum import decayed, spread_and_gain
from gpsec.detection.learned import Learned, OnStage, silent
from gpsec.detection.logs import Grid, ResidualLog, sessions

# Innovations beyond this many standard deviations count as that many, so that a few matches to the wrong lane do
# not blow up the variance (Huber).
_CLIP = 3.0
_START = (0.7, 0.7, 30.0)
_BOUNDS = ((1e-3, 10.0), (1e-3, 10.0), (1.0, 600.0))


def learn_whitening(logs: Sequence[ResidualLog], seed: int, progress: OnStage = silent) -> Learned:
    """Return σ_w, σ_b (in scales) and τ that make benign residuals most likely; `seed` is not needed."""
    progress("training cusum", 0, 1)
    grid = Grid.of(logs)
    found = sessions(grid, steps_in(GAP_S, grid.step_s))
    values = np.concatenate([grid.residual_m[steps, v] / grid.scale_m[v] for v, steps in found] or [np.zeros(0)])
    elapsed = np.concatenate([np.diff(steps, prepend=steps[:1]) * grid.step_s for _, steps in found] or [np.zeros(0)])
    first = np.concatenate([[0], np.cumsum([len(steps) for _, steps in found])]).astype(np.int32)

    best, best_cost, stride = [log(x) for x in _START], inf, 1.0
    # Compass search: the cost is smooth and has three arguments; a step of 3 % is finer than CUSUM can feel.
    while stride > 0.03:
        trials = [best] if best_cost == inf else _neighbours(best, stride)
        costs = [_negative_log_likelihood(values, elapsed, first, *(exp(x) for x in trial)) for trial in trials]
        cheapest = int(np.argmin(costs))
        if costs[cheapest] < best_cost:
            best, best_cost = trials[cheapest], costs[cheapest]
        else:
            stride *= 0.5
    progress("training cusum", 1, 1)
    white, slow, tau_s = (exp(x) for x in best)
    return {"white": np.asarray(white), "slow": np.asarray(slow), "tau_s": np.asarray(tau_s)}


def _neighbours(point: list[float], stride: float) -> list[list[float]]:
    """Return the points one stride away along each axis, within the bounds."""
    found = []
    for axis, (low, high) in enumerate(_BOUNDS):
        for move in (-stride, stride):
            moved = list(point)
            moved[axis] = min(max(moved[axis] + move, log(low)), log(high))
            found.append(moved)
    return found


@kernel
def _negative_log_likelihood(
    values: Floats, elapsed_s: Floats, first: Ints, white: float, slow: float, tau_s: float
) -> float:
    """Return the mean over the samples; session s is values[first[s]:first[s + 1]]."""
    total = 0.0
    for s in range(len(first) - 1):
        level, variance = 0.0, 1.0
        for t in range(first[s], first[s + 1]):
            decay = np.exp(-elapsed_s[t] / tau_s)
            level, variance = decayed(decay, level, variance)
            spread, gain = spread_and_gain(white, slow, variance)
            innovation = values[t] - level
            e = abs(innovation) / np.sqrt(spread)
            loss = 0.5 * e * e if e < _CLIP else _CLIP * e - 0.5 * _CLIP * _CLIP
            total += loss + 0.5 * np.log(spread)
            level += gain * innovation
            variance *= 1.0 - gain
    return total / max(len(values), 1)
