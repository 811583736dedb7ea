"""Compares two runs vehicle by vehicle: the same vehicle, attacked at the same time, in one run and in the other."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import Figures, percentile_interval, ratio
from gpsec.outcomes.state import OUT_OF_LANE, OUTCOMES
from gpsec.running.results import Results

_KEYS = ["scenario", "vehicle_id", "attack", "defence"]
_GROUP = ["scenario", "profile", "attack", "defence"]
# Columns of an event that are compared -> their titles.
FIGURES = {
    "left_lane": "share that would have left their lane",
    "rmse_cross_track_m": "RMSE across the lane (m)",
    "max_cross_track_m": "largest error across the lane (m)",
    "rmse_xy_m": "RMSE of the position (m)",
    "detected": "share of the attacks seen",
    "detection_delay_s": "delay, where both saw the attack (s)",
}
FALSE_ALARMS = "false alarms per vehicle-hour"
_FEWEST_VEHICLES = 2


def pairs(first: Results, second: Results) -> tuple[pd.DataFrame, int]:
    """Return the events that are in both runs, columns of the second with ``_b``, and the number that are in one alone.

    Raises:
        GpsecError: there is none in both.
    """
    mine, other = (_events(run) for run in (first, second))
    both = mine.merge(other.drop(columns="profile"), on=_KEYS, suffixes=("", "_b"))
    # A vehicle that is attacked at another time meets another road: it is no pair.
    both = both[(both["start_s"] - both["start_s_b"]).abs() < 1e-6]
    if both.empty:
        raise GpsecError(
            f"{second.folder}: expected a run with attacked vehicles and defences of {first.folder}, found none that"
            " are the same in both; the scenarios, the seed and the attack windows have to be the same"
        )
    return both.reset_index(drop=True), len(mine) + len(other) - 2 * len(both)


def comparison(first: Results, second: Results) -> pd.DataFrame:
    """Return a row for every scenario, profile, attack, defence and figure.

    Columns: those names, ``figure``, ``n_vehicles`` (pairs that have the figure), ``first``, ``second``, ``difference``
    (second − first) with its bounds ``_lo`` and ``_hi`` by bootstrap over vehicles, empty where fewer than two have it.

    Raises:
        GpsecError: no vehicle is in both runs.
    """
    stated = first.scenarios[0]["configuration"]
    settings = stated["outcomes"]
    bootstrap = Bootstrap(int(stated.get("seed", 1)), settings["bootstrap"], settings["confidence"])
    rows: list[dict[str, object]] = []
    for names, events in pairs(first, second)[0].groupby(_GROUP, sort=False):
        label = "/".join(map(str, names))
        shown = dict(zip(_GROUP, names, strict=True))
        for column, figure in FIGURES.items():
            values = events[[column, f"{column}_b"]].to_numpy(np.float64)
            known = np.isfinite(values).all(axis=1)
            if known.any():
                ones = np.ones(int(known.sum()))
                cells = _difference(values[known], np.stack([ones, ones], axis=1), bootstrap, f"{label}/{column}")
                rows.append({**shown, "figure": figure, "n_vehicles": int(known.sum()), **cells})
    return pd.DataFrame([*rows, *_false_alarms(first, second, bootstrap)])


def _false_alarms(first: Results, second: Results, bootstrap: Bootstrap) -> Sequence[dict[str, object]]:
    """Return the rows on vehicles without an attack."""
    columns = [*_KEYS, "profile", "false_alarms", "vehicle_seconds"]
    mine, other = (
        run.vehicles.loc[run.vehicles["attack"] == "none", columns].astype(dict.fromkeys([*_KEYS, "profile"], str))
        for run in (first, second)
    )
    both = mine.merge(other.drop(columns="profile"), on=_KEYS, suffixes=("", "_b"))
    rows = []
    for names, vehicles in both.groupby(_GROUP, sort=False):
        alarms = vehicles[["false_alarms", "false_alarms_b"]].to_numpy(np.float64)
        hours = vehicles[["vehicle_seconds", "vehicle_seconds_b"]].to_numpy(np.float64) / 3600.0
        if not hours.sum(axis=0).all():
            continue
        cells = _difference(alarms, hours, bootstrap, "/".join(map(str, names)) + "/false alarms")
        shown = dict(zip(_GROUP, names, strict=True))
        rows.append({**shown, "figure": FALSE_ALARMS, "n_vehicles": len(vehicles), **cells})
    return rows


def _difference(values: Floats, weights: Floats, bootstrap: Bootstrap, label: str) -> dict[str, float]:
    """Return both figures, Σ (V, 2) values / Σ (V, 2) weights, and their difference with its interval."""
    sums = bootstrap.sums(label, np.concatenate([values, weights], axis=1))
    once = values.sum(axis=0) / weights.sum(axis=0)
    part = ratio(sums[:, :2], sums[:, 2:])
    resampled = Figures(part.value[:, 1] - part.value[:, 0], part.known[:, 0] & part.known[:, 1])
    low, high = (float(bound.value) for bound in percentile_interval(resampled, bootstrap.confidence))
    enough = len(values) >= _FEWEST_VEHICLES
    return {
        "first": float(once[0]),
        "second": float(once[1]),
        "difference": float(once[1] - once[0]),
        "difference_lo": low if enough else np.nan,
        "difference_hi": high if enough else np.nan,
    }


def _events(run: Results) -> pd.DataFrame:
    columns = [*_KEYS, "profile", "start_s", "outcome", *(name for name in FIGURES if name != "left_lane")]
    events = run.events[columns].astype(dict.fromkeys([*_KEYS, "profile", "outcome"], str))
    return events.assign(left_lane=events["outcome"].isin(OUTCOMES[OUT_OF_LANE:]))
