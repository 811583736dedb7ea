"""The table `curves.csv`: points of each detector's ROC and precision-recall curve."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints, Longs
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.histograms import lower_edges, negatives
from gpsec.outcomes.state import FP, TN
from gpsec.outcomes.study import Study

# Enough for a line that looks like the curve through all bins.
POINTS = 80
# Detectors are used at rates of 1e-2 to 1e-4, which are next to nothing on a linear axis: they get points as well.
_LOWEST_RATE = 1e-5

_COLUMNS = (
    "scenario",
    "profile",
    "attack",
    "detector",
    "threshold",
    "false_positive_rate",
    "recall",
    "precision",
)


class Curve(NamedTuple):
    """Points (n,) of a detector, from the highest threshold to the lowest; a statistic of at least it is an alarm."""

    threshold: Floats
    false_positive_rate: Floats
    recall: Floats
    precision: Floats


def curve(negative: Floats, positive: Floats) -> Curve | None:
    """Return at most about `POINTS` points of (BINS,) weights of negatives and positives; None where a class is empty.

    They are spread evenly along the way of the curve, which is counted in all three rates and in the logarithm of the
    false-positive rate.
    """
    total_negative, total_positive = float(negative.sum()), float(positive.sum())
    if total_negative <= 0.0 or total_positive <= 0.0:
        return None
    used = np.flatnonzero((negative > 0.0) | (positive > 0.0))[::-1]
    false_positive, true_positive = np.cumsum(negative[used]), np.cumsum(positive[used])
    points = Curve(
        lower_edges()[used],
        np.minimum(false_positive / total_negative, 1.0),
        np.minimum(true_positive / total_positive, 1.0),
        true_positive / (false_positive + true_positive),
    )
    chosen = _spread(points)
    return Curve(*(values[chosen] for values in points))


def _spread(points: Curve) -> Ints:
    small = np.log10(np.maximum(points.false_positive_rate, _LOWEST_RATE)) / -np.log10(_LOWEST_RATE)
    axes = np.stack([points.false_positive_rate, points.recall, points.precision, small])
    way = np.abs(np.diff(axes, axis=1, prepend=axes[:, :1])).sum(axis=0).cumsum()
    part = np.floor(way / max(float(way[-1]), 1e-12) * POINTS)
    chosen = np.flatnonzero(np.diff(part, prepend=-1.0))
    return np.unique(np.append(chosen, len(way) - 1)).astype(np.int32)


def curves_table(study: Study, tracks: ClosedTracks, histogram: Longs, scenario: str) -> pd.DataFrame:
    """Return the points for every profile, attack and detector; none where the curves are not defined."""
    parts = [pd.DataFrame({name: np.zeros(0, object if place < 4 else float) for place, name in enumerate(_COLUMNS)})]
    for profile, name in enumerate(study.profiles):
        mine = tracks.take(tracks.profile == profile)
        for plan, attack in enumerate(study.plans[1:], start=1):
            scored = mine.of_plan(plan).state.counts[..., [FP, TN]].sum(axis=(0, 2), dtype=np.int64)
            for k, detector in enumerate(study.detectors):
                attacked = histogram[plan, profile, k, 1]
                points = curve(negatives(histogram[0, profile, k, 0], int(scored[k])), attacked)
                if points is not None:
                    names = {"scenario": scenario, "profile": name, "attack": attack, "detector": detector}
                    parts.append(pd.DataFrame({**names, **points._asdict()}))
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True)
