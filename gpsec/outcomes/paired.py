"""Compares defences by pairs: the same vehicles under both, and each vehicle counts once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.outcomes.bootstrap import Bootstrap


@dataclass(frozen=True)
class PairedDifference:
    """A defence less the best one, over the same vehicles.

    Attributes:
        mean: of the share of its attacks that put a vehicle out of its lane; positive where the best one is better.
        low, high: simultaneous bounds of it.
        better, worse: vehicles that the best one serves better, and worse.
        apart: the two can be told apart.
    """

    mean: float
    low: float
    high: float
    better: int
    worse: int
    apart: bool


def resampled_means(shares: Floats, runs: Ints, bootstrap: Bootstrap, label: str) -> Floats:
    """Return (B, D) means over resampled vehicles of (V, D) `shares`; (V,) `runs` numbers the run of each vehicle.

    Of several runs, whole runs are drawn, then their vehicles.
    """
    vehicles = len(shares)
    if len(np.unique(runs)) > 1:
        weights = bootstrap.weights(label, runs)
        return np.asarray(weights @ shares / np.maximum(weights.sum(axis=1), 1.0)[:, None])
    return bootstrap.sums(label, shares) / max(vehicles, 1)


def against_best(
    shares: Floats, means: Floats, choice: Sequence[int], confidence: float
) -> tuple[int, list[PairedDifference]]:
    """Return the column of `choice` with the smallest mean, and the difference of every column from it.

    Two are apart where the bootstrap interval of the mean difference excludes zero, and so does the exact sign test of
    the vehicles that fare differently (Dixon and Mood, JASA 1946): a bootstrap of few of these is too sure. Of C
    choices, C − 1 are compared with the best, so each at 1 − (1 − confidence) / (C − 1) (Bonferroni).

    Args:
        shares: (V, D) of each vehicle's attacks that put it out of its lane.
        means: (B, D) of resampled vehicles, see `resampled_means`.
        choice: columns among which the best is looked for.
        confidence: of all comparisons together.
    """
    best = choice[int(np.argmin(shares[:, choice].mean(axis=0)))]
    alpha = (1.0 - confidence) / max(len(choice) - 1, 1)
    return best, [_difference(shares, means, column, best, alpha) for column in range(shares.shape[1])]


def _difference(shares: Floats, means: Floats, column: int, best: int, alpha: float) -> PairedDifference:
    each = shares[:, column] - shares[:, best]
    low, high = np.quantile(means[:, column] - means[:, best], [0.5 * alpha, 1.0 - 0.5 * alpha])
    better, worse = int((each > 0.0).sum()), int((each < 0.0).sum())
    apart = bool(low > 0.0 or high < 0.0) and sign_test(better, worse) < alpha
    return PairedDifference(float(each.mean()), float(low), float(high), better, worse, apart)


def sign_test(better: int, worse: int) -> float:
    """Return the two-sided p-value of the exact sign test; 1 where no vehicle fares differently."""
    from scipy.stats import binomtest

    return float(binomtest(better, better + worse).pvalue) if better + worse else 1.0


def shares_of_vehicles(vehicle: Ints, defence: Ints, out: Flags, shape: tuple[int, int]) -> Floats:
    """Return (V, D) shares of the attacks on a vehicle that put it out of its lane.

    Args:
        vehicle: (E,) number of the vehicle of each row of `events.csv`.
        defence: (E,) number of its defence.
        out: (E,) whether it left its lane.
        shape: (V, D).
    """
    total, left = np.zeros(shape), np.zeros(shape)
    np.add.at(total, (vehicle, defence), 1.0)
    np.add.at(left, (vehicle, defence), out.astype(np.float64))
    return np.divide(left, total, out=np.zeros(shape), where=total > 0.0)


def named_together(names: Sequence[str], most: int = 3) -> str:
    """Return names as one text: ``a, b and 4 more``."""
    if len(names) > most:
        return f"{', '.join(names[: most - 1])} and {len(names) - most + 1} more"
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else list(names))
