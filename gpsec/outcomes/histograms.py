"""Histograms of detectors' statistics, and the areas under the curves that follow from them.

Bins are exact parts of an octave: a statistic s = m·2ᵉ with 0.5 ≤ m < 1 falls into one of `PER_OCTAVE` equal parts
of [2ᵉ⁻¹, 2ᵉ). A bin is therefore 0.4 to 0.8 % of the statistic wide everywhere between 2⁻²⁰ and 2²⁰ (about 1e-6 and
1e6), which serves unbounded statistics and scores in 0 … 1 alike (0.002 wide from 0.25, 0.004 from 0.5), and no
logarithm is rounded. What is lower (zero too) or higher has a bin of its own at either end.
"""

from dataclasses import dataclass
from math import frexp

import numpy as np

from gpsec.core.arrays import Floats, Ints, Longs
from gpsec.core.kernels import inline, kernel
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

PER_OCTAVE = 128
LOWEST_OCTAVE, HIGHEST_OCTAVE = -20, 20
BINS = (HIGHEST_OCTAVE - LOWEST_OCTAVE) * PER_OCTAVE + 2


@inline
def bin_of(statistic: float) -> int:
    """Return the bin of `statistic`; a higher one never has a lower bin."""
    if not statistic >= 2.0**LOWEST_OCTAVE:
        return 0
    if statistic >= 2.0**HIGHEST_OCTAVE:
        return BINS - 1
    mantissa, exponent = frexp(statistic)
    return 1 + (exponent - 1 - LOWEST_OCTAVE) * PER_OCTAVE + int((mantissa - 0.5) * (2.0 * PER_OCTAVE))


@kernel
def count(rows: Ints, tracks: Tracks, vehicles: Vehicles, bins: Ints, histogram: Longs) -> None:
    """Add one to the (P, profiles, K, 2, BINS) histogram for every (M, K) bin of `rows` that is not -1.

    Several rows share a cell, so this is not for more than one thread; the sums do not depend on the order.
    """
    for row in rows:
        label = 1 if tracks.attacked[row] else 0
        cell = histogram[tracks.plan[row], vehicles.profile[tracks.vehicle[row]]]
        for k in range(bins.shape[1]):
            if bins[row, k] >= 0:
                cell[k, label, bins[row, k]] += 1


@dataclass(frozen=True)
class Areas:
    """Areas under the curves of one detector: ROC and precision-recall."""

    roc: float
    pr: float


def areas(negative: Floats, positive: Floats) -> Areas | None:
    """Return the areas under the curves of (BINS,) weights of negatives and positives, None where a class is empty.

    Every bin is a threshold. ROC by trapezoids (statistics in one bin count half, as in the rank statistic of Mann
    and Whitney). Precision-recall by steps, Σ (Rᵢ − Rᵢ₋₁)·Pᵢ, since straight lines between its points promise
    what no threshold reaches (Davis and Goadrich, ICML 2006).
    """
    total_negative, total_positive = float(negative.sum()), float(positive.sum())
    if total_negative <= 0.0 or total_positive <= 0.0:
        return None
    false_positive = np.cumsum(negative[::-1])
    true_positive = np.cumsum(positive[::-1])
    called = false_positive + true_positive
    precision = np.divide(true_positive, called, out=np.zeros_like(called), where=called > 0.0)
    gain = np.diff(true_positive, prepend=0.0)
    height = true_positive - 0.5 * gain
    width = np.diff(false_positive, prepend=0.0)
    return Areas(
        roc=float(np.sum(width * height)) / (total_negative * total_positive),
        pr=float(np.sum(gain * precision)) / total_positive,
    )


def negatives(benign: Longs, after: Longs, scored: int) -> Floats:
    """Return the (BINS,) weights of the negatives of attacked tracks: `scored` samples in all.

    Precision and recall count a track's unattacked samples before and after the attack. Those after it are known
    exactly (`after`); a histogram for every vehicle would not fit, so those before it are taken to be distributed as
    the samples of all vehicles of that profile without an attack (`benign`).
    """
    before = max(scored - int(after.sum()), 0)
    total = int(benign.sum())
    return after + benign * (before / total) if total else after.astype(np.float64)
