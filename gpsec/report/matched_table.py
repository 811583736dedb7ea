"""The table `matched` of `gpsec table`: detectors where all of them have the same false positives."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import pandas as pd

from gpsec.outcomes.naming import base_name
from gpsec.report.formatting import EMPTY, figure
from gpsec.report.gathering import Gathered
from gpsec.report.typesetting import TypesetTable, label, ruled
from gpsec.scenario.choices import BOUNDS
from gpsec.types.points import detector_at

# Of benign samples; the paper's tables are at the second.
_RATES = (1e-2, 1e-3, 1e-4)
# With fewer false positives than these in all runs, a rate cannot be told.
_FEWEST = 5
# Residuals are formed that often, at most.
_SAMPLES_HZ = 10.0


def matched_tables(found: Gathered) -> Iterator[TypesetTable]:
    """Yield, for each scenario and profile, the recall of every detector at each of `_RATES`, over seeds."""
    curves = found.tables["curves"]
    curves = curves[~curves["detector"].isin(BOUNDS)]
    for keys, mine in curves.groupby([curves["scenario"].map(base_name), "profile"], sort=False):
        scenario, profile = map(str, keys)
        mine = mine[mine["detector"].isin(one_point_each(mine["detector"].unique()))]
        samples = _benign_samples(found, scenario, profile)
        lines = [
            [
                *(str(attack), str(detector)),
                *(_over_seeds(points, r, found.confidence) if r * samples >= _FEWEST else EMPTY for r in _RATES),
            ]
            for (attack, detector), points in mine.groupby(["attack", "detector"], sort=False)
        ]
        several = len(found.seeds.get(scenario, ())) > 1
        over = f"mean and {found.confidence:.0%} interval (Student's t) over " if several else ""
        caption = (
            f"Detectors at equal false alarms, {scenario}, profile {profile}: share of the samples under attack that"
            " are alarmed, at the lowest threshold of each detector by which no more than that share of the samples"
            f" without an attack is (–: fewer than {_FEWEST} of them);"
            f" n = up to {_most_events(found, scenario, profile)} events an attack,"
            f" {over}{found.over(scenario)}; {found.made_by}."
        )
        headings = ["attack", "detector", *(f"recall at {rate:g}" for rate in _RATES)]
        yield TypesetTable(label("matched", scenario, profile), caption, headings, ruled(lines))


def one_point_each(names: Iterable[str]) -> list[str]:
    """Return one name of each detector, its first: a curve has all thresholds, so that points of one are the same."""
    first: dict[str, str] = {}
    for name in names:
        first.setdefault(detector_at(name), name)
    return list(first.values())


def recall_at(points: pd.DataFrame, rate: float) -> float:
    """Return the largest recall of `points`, rows of curves.csv, with at most `rate` false positives."""
    return float(points.loc[points["false_positive_rate"] <= rate, "recall"].max())


def _over_seeds(points: pd.DataFrame, rate: float, confidence: float) -> str:
    each = [recall_at(run, rate) for _, run in points.groupby("scenario", sort=False)]
    low, high = mean_bounds(each, confidence)
    text = figure(float(np.mean(each)))
    return text if np.isnan(low) else f"{text} ({figure(low)} – {figure(high)})"


def mean_bounds(shares: Sequence[float], confidence: float) -> tuple[float, float]:
    """Return the bounds of the mean of `shares`, one of each run, by Student's t; NaN for a single run."""
    from scipy.stats import t

    if len(shares) < 2:
        return np.nan, np.nan
    half = t.ppf(0.5 + confidence / 2.0, len(shares) - 1) * np.std(shares, ddof=1) / np.sqrt(len(shares))
    mean = float(np.mean(shares))
    return max(mean - half, 0.0), min(mean + half, 1.0)


def _benign_samples(found: Gathered, scenario: str, profile: str) -> float:
    """Return how many samples without an attack there were in all runs, of the detector that scored most."""
    honest = found.tables["vehicles"]
    honest = honest[(honest["attack"] == "none") & (honest["profile"] == profile)]
    honest = honest[honest["scenario"].map(base_name) == scenario]
    return float(honest.groupby("defence")["scored_seconds"].sum().max() * _SAMPLES_HZ)


def _most_events(found: Gathered, scenario: str, profile: str) -> int:
    table = found.tables["detection"]
    mine = table[(table["scenario"] == scenario) & (table["profile"] == profile)]
    return int(mine["n_events"].max())
