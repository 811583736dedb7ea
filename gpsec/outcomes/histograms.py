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
from gpsec.outcomes.state import OutcomeState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

PER_OCTAVE = 128
LOWEST_OCTAVE, HIGHEST_OCTAVE = -20, 20
# With fewer expected false alarms than that, a threshold says what happened to happen.
FEWEST_EVENTS = 5.0
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
def count(
    rows: Ints,
    tracks: Tracks,
    vehicles: Vehicles,
    sums: OutcomeState,
    unscored_steps: Ints,
    hold_steps: int,
    histogram: Longs,
    rises: Longs,
) -> None:
    """Add one to the (P, profiles, K, 2, BINS) histogram for every (M, K) bin of `rows` that is not -1.

    To the (profiles, K, BINS) `rises` add, for every benign track whose statistic went up, one in its new bin, and take
    one from the bin that it was in: the sum from a bin on is then the number of alarms that a threshold at the lower
    edge of that bin would have raised. An alarm without a score for more than `hold_steps` would have ended.

    Several rows share a cell, so this is not for more than one thread; the sums do not depend on the order.
    """
    bins = sums.bin
    for row in rows:
        label = 1 if tracks.attacked[row] else 0
        profile = vehicles.profile[tracks.vehicle[row]]
        cell = histogram[tracks.plan[row], profile]
        for k in range(bins.shape[1]):
            if bins[row, k] >= 0:
                cell[k, label, bins[row, k]] += 1
            if tracks.plan[row] > 0:
                continue
            last = sums.last_bin[row, k]
            if bins[row, k] >= 0:
                if bins[row, k] > last:
                    rises[profile, k, bins[row, k]] += 1
                    rises[profile, k, last] -= 1
                sums.last_bin[row, k] = bins[row, k]
            elif unscored_steps[row, k] > hold_steps:
                sums.last_bin[row, k] = 0


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


def negatives(benign: Longs, scored: int) -> Floats:
    """Return the (BINS,) weights of `scored` negatives that are distributed as the samples without an attack.

    Samples behind an attack, in which a window still holds it, are nobody's false alarms, and differ with the length of
    the windows: a curve with them says which window is short. How long an alarm outlasts the attack is a figure of its
    own.
    """
    total = int(benign.sum())
    weights: Floats = benign.astype(np.float64)
    return weights * (scored / total) if total else weights


@dataclass(frozen=True)
class MatchedThreshold:
    """What a detector would do at a threshold that is re-set on the benign twins of the scored run.

    Attributes:
        threshold: the lowest at which they have no more false alarms than asked for.
        recall: share of the samples under attack above it.
    """

    threshold: float
    recall: float


def matched(benign: Longs, attacked: Longs, allowed: float, events: Longs | None = None) -> MatchedThreshold | None:
    """Return what is left at a threshold with `allowed` false alarms, of (BINS,) counts; None where none can be told.

    Args:
        benign: statistics of the samples without an attack.
        attacked: of those under attack.
        allowed: number of samples, or of alarms where their `events` are given.
        events: for each bin, alarms that a threshold at its lower edge would raise; else samples above it.
    """
    above = np.cumsum(benign[::-1])[::-1] if events is None else events
    total = int(attacked.sum())
    if not total or not benign.sum():
        return None
    place = _lowest_place(above, allowed)
    if place is None:
        return None
    return MatchedThreshold(_lowest(place), float(attacked[place:].sum() / total))


def lowest_threshold(above: Longs, allowed: float) -> float | None:
    """Return the lowest threshold with at most `allowed` false alarms, None where these are too few to be told.

    `above` (BINS,) has, for each bin, the samples in it and higher ones, or the alarms that a threshold at its lower
    edge would raise.
    """
    place = _lowest_place(above, allowed)
    return None if place is None else _lowest(place)


def _lowest_place(above: Longs, allowed: float) -> int | None:
    if allowed < FEWEST_EVENTS:
        return None
    return int(np.flatnonzero(np.append(above > allowed, False)).max(initial=-1)) + 1


def _lowest(place: int) -> float:
    return float(np.append(lower_edges(), np.inf)[place])


def lower_edges() -> Floats:
    """Return the (BINS,) lowest statistic of each bin; 0 for the first."""
    octave, part = np.divmod(np.arange(BINS - 1), PER_OCTAVE)
    return np.concatenate([[0.0], np.ldexp(1.0 + part / PER_OCTAVE, octave + LOWEST_OCTAVE)])
