"""What an attack does to the traffic: each world less its benign twin of the same seed, `effects.csv`."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats
from gpsec.outcomes.naming import scenario_of_world
from gpsec.types.constants import UNDEFENDED

MEASURES = ("collisions_per_1000_vkm", "delay_s", "standing_share", "mean_speed_mps", "arrived")
BENIGN_PLAN = "none"
WORLD_KEY = ["scenario", "plan", "defence", "on_alarm", "false_alarms_per_h"]
_RESAMPLES, _SEED = 4000, 2026


def effects_table(worlds: pd.DataFrame, confidence: float = 0.95) -> pd.DataFrame:
    """Return a row for each scenario, plan, defence, reaction and rate of injected alarms, but for the benign twins.

    Of each of `MEASURES` there are the mean over the benign twins, the mean of the differences of pairs of one seed,
    and the interval of that by bootstrap over the seeds, which is missing where there is one seed only.
    """
    rows = []
    for names, group, twins in with_twins(with_collision_rates(worlds)):
        paired = twins["vehicle_km"].notna().to_numpy()
        row = names | {"seeds": int(paired.sum())}
        for measure in MEASURES:
            without = twins[measure].to_numpy(np.float64)[paired]
            difference = group[measure].to_numpy(np.float64)[paired] - without
            low, high = mean_interval(difference, confidence)
            mean = (difference.mean(), without.mean()) if len(difference) else (np.nan, np.nan)
            row |= {f"twin_{measure}": mean[1], measure: mean[0], f"{measure}_low": low, f"{measure}_high": high}
        rows.append(row)
    columns = [f"{before}{measure}{after}" for measure in MEASURES for before, after in _PARTS]
    return pd.DataFrame(rows, columns=[*WORLD_KEY, "seeds", *columns])


def with_twins(worlds: pd.DataFrame) -> Iterator[tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]]:
    """Yield what tells worlds apart but for their seeds, their rows, and those of their twins, empty without one.

    `worlds` are under the names of their scenarios, see `with_collision_rates`.
    """
    twin = (worlds["plan"] == BENIGN_PLAN) & (worlds["false_alarms_per_h"] == 0.0)
    benign = worlds[twin].set_index(["scenario", "on_alarm", "defence", "seed"])
    there = {key[:3] for key in benign.index}
    for key, group in worlds[~twin].groupby(WORLD_KEY, sort=False):
        names = dict(zip(WORLD_KEY, key, strict=True))
        place = names["scenario"], names["on_alarm"]
        # Where nobody is steered without an attack, one benign world is the twin of all defences.
        of = names["defence"] if (*place, names["defence"]) in there else UNDEFENDED
        yield names, group, benign.reindex([(*place, of, seed) for seed in group["seed"]])


def with_collision_rates(worlds: pd.DataFrame) -> pd.DataFrame:
    """Return worlds under the names of their scenarios, with collisions in 1,000 vehicle-kilometres."""
    return worlds.assign(
        scenario=[scenario_of_world(name) for name in worlds["scenario"]],
        collisions_per_1000_vkm=1000.0 * worlds["collisions"] / worlds["vehicle_km"].clip(lower=1e-9),
    )


_PARTS = (("twin_", ""), ("", ""), ("", "_low"), ("", "_high"))


def mean_interval(values: Floats, confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval of the mean of (n,) seeds by bootstrap, NaN where there are fewer than two."""
    if len(values) < 2:
        return float("nan"), float("nan")
    draws = np.random.default_rng(_SEED).integers(0, len(values), (_RESAMPLES, len(values)))
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(values[draws].mean(axis=1), [tail, 100.0 - tail])
    return float(low), float(high)
