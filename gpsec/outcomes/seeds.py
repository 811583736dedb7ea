"""The tables of several runs of one scenario, each with a seed of its own, taken together.

Runs differ by more than their vehicles do: a slow error of the receivers, or a jam, is common to a run. So intervals
come from a bootstrap of whole runs, and within each drawn run of its vehicles.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import Figures
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.records import cells
from gpsec.outcomes.state import OUTCOMES
from gpsec.types.constants import UNDEFENDED

POOLED = ("detection", "localization", "safety")
_ERRORS = ("rmse_x_m", "rmse_y_m", "rmse_xy_m", "rmse_cross_track_m", "rmse_along_track_m")
_Tables = Mapping[str, pd.DataFrame]
_Row = dict[str, Any]


def pooled_tables(tables: _Tables, bootstrap: Bootstrap) -> dict[str, pd.DataFrame]:
    """Return `POOLED` with the rows of all scenarios that were run with several seeds, and the columns of one run.

    `n_runs` comes on top. What events and vehicles do not tell (areas, matched figures, quantiles of the delay, an
    operating point that no defence uses) is left out.
    """
    runs: dict[str, list[str]] = {}
    for scenario in tables["safety"]["scenario"].unique():
        runs.setdefault(base_name(scenario), []).append(scenario)
    found: dict[str, list[pd.DataFrame]] = {name: [] for name in POOLED}
    for base, members in runs.items():
        if len(members) > 1:
            mine = {name: table[table["scenario"].isin(members)] for name, table in tables.items()}
            for name, table in pooled(base, mine, bootstrap).items():
                found[name].append(table)
    return {name: pd.concat(parts, ignore_index=True) for name, parts in found.items() if parts}


def pooled(base: str, tables: _Tables, bootstrap: Bootstrap) -> dict[str, pd.DataFrame]:
    """Return `POOLED` of runs that are all of the scenario `base`; `tables` are as in `pooled_tables`."""
    return _Pool(base, tables, bootstrap).tables()


class _Pool:
    """The runs of one scenario."""

    def __init__(self, base: str, tables: _Tables, bootstrap: Bootstrap) -> None:
        self._base = base
        self._tables = tables
        self._bootstrap = bootstrap

    def tables(self) -> dict[str, pd.DataFrame]:
        rows: dict[str, list[_Row]] = {name: [] for name in POOLED}
        safety = self._tables["safety"]
        for profile, attack in safety[["profile", "attack"]].drop_duplicates().itertuples(index=False, name=None):
            group = _Group(self._tables, profile, attack, self._bootstrap)
            head = {"scenario": self._base, "profile": profile, "attack": attack}
            seen: set[str] = set()
            for defence in safety["defence"].unique():
                detector = defence.partition("+")[0]
                if detector not in seen:
                    seen.add(detector)
                    rows["detection"].append(head | {"detector": detector} | group.detection(defence))
                rows["localization"].append(head | {"defence": defence} | group.localization(defence))
                rows["safety"].append(head | {"defence": defence} | group.safety(defence))
        return {name: self._like(name, rows[name]) for name in POOLED}

    def _like(self, name: str, rows: Sequence[_Row]) -> pd.DataFrame:
        columns = list(self._tables[name].columns)
        return pd.DataFrame(rows).reindex(columns=[*columns, "n_runs"])


class _Group:
    """The vehicles of one profile under one attack, in all runs."""

    def __init__(self, tables: _Tables, profile: str, attack: str, bootstrap: Bootstrap) -> None:
        self._bootstrap = bootstrap
        self._attacked = attack != "none"
        honest = self._of(tables["vehicles"], profile, "none")
        self._honest = honest[honest["vehicle_seconds"] > 0]  # a run leaves out who never settled, too
        self._mine = self._of(tables["events"], profile, attack) if self._attacked else self._honest
        self._stated = {name: self._of(tables[name], profile, attack) for name in POOLED}
        self._label = f"{profile}/{attack}"
        self._weights: dict[str, tuple[Floats, Ints]] = {}

    @staticmethod
    def _of(table: pd.DataFrame, profile: str, attack: str) -> pd.DataFrame:
        return table[(table["profile"] == profile) & (table["attack"] == attack)]

    def detection(self, defence: str) -> _Row:
        mine, honest = self._rows(self._mine, defence), self._rows(self._honest, defence)
        stated = self._stated["detection"]
        stated = stated[stated["detector"] == defence.partition("+")[0]]
        row: _Row = {name: stated[name].iloc[0] for name in ("rate", "threshold", "threshold_from")}
        row |= {
            "n_runs": stated["scenario"].nunique(),
            "n_events": len(mine) if self._attacked else 0,
            "n_line_events": 0,
        }
        if self._attacked:
            line = self._rows(self._mine, UNDEFENDED)["time_to_line_s"].to_numpy()
            row |= self._of_events(mine, line)
        hours = honest["vehicle_seconds"] / 3600.0
        row |= self._ratio("false_alarms_per_vehicle_hour", honest, honest["false_alarms"], hours)
        if len(honest) and not honest["false_alarms"].any():
            bound = metrics.poisson_bound_of_none(np.array([hours.sum()]), self._bootstrap.confidence)
            row |= {"false_alarms_per_vehicle_hour_lo": 0.0, "false_alarms_per_vehicle_hour_hi": float(bound.value[0])}
        return row | {"vehicle_hours": float(hours.sum())}

    def _of_events(self, mine: pd.DataFrame, line_s: Floats) -> _Row:
        samples = [mine[f"{name}s"].to_numpy() for name in ("true_positive", "false_positive", "false_negative")]
        row: _Row = {}
        for name, of in _SCORES.items():
            row |= self._figure(name, mine, samples, of)
        detected = mine["detected"].to_numpy()
        delay = mine["detection_delay_s"].fillna(0.0)
        row |= self._ratio("delay_mean_s", mine, delay, detected)
        ones = np.ones(len(mine))
        row |= self._ratio("detected_share", mine, detected, ones)
        row |= self._ratio("detected_not_twin_share", mine, mine["detected_not_twin"], ones)
        touched = ~np.isnan(line_s)
        before = touched & detected & (mine["detection_delay_s"].to_numpy() < line_s)
        row |= {"n_line_events": int(touched.sum())}
        row |= self._ratio("seen_before_line_share", mine, before, touched)
        late = mine["alarm_ends_after_s"]
        return row | self._ratio("alarm_ends_after_mean_s", mine, late.fillna(0.0), late.notna())

    def localization(self, defence: str) -> _Row:
        mine = self._rows(self._mine, defence)
        row: _Row = {"n_runs": self._stated["localization"]["scenario"].nunique(), "n_vehicles": len(mine)}
        row["n_events"] = len(mine) if self._attacked else 0
        time = mine["attack_seconds"] if self._attacked else mine["vehicle_seconds"]
        for name in _ERRORS if self._attacked else ("rmse_xy_m",):
            squared = mine[name].fillna(0.0) ** 2 * time
            row |= self._figure(name, mine, [squared.to_numpy(), time.to_numpy()], _rmse)
        row["max_cross_track_m"] = mine["max_cross_track_m"].max()
        if self._attacked:
            total = (mine["twin_rmse_xy_m"].fillna(0.0) ** 2 * time).sum()
            row["twin_rmse_xy_m"] = float(np.sqrt(total / time.sum())) if time.sum() else np.nan
        return row

    def safety(self, defence: str) -> _Row:
        mine, honest = self._rows(self._mine, defence), self._rows(self._honest, defence)
        stated = self._stated["safety"]
        stated = stated[stated["defence"] == defence]
        row: _Row = {"n_runs": stated["scenario"].nunique(), "n_vehicles": len(mine)}
        hours = honest["vehicle_seconds"] / 3600.0
        row |= self._ratio("isolated_minutes_per_vehicle_hour", honest, honest["isolated_seconds"] / 60.0, hours)
        notes = stated["note"].dropna()
        if len(notes):
            return row | {"note": notes.iloc[0]}
        ones = np.ones(len(mine))
        for place, outcome in enumerate(OUTCOMES):
            came_to = reaches(mine["outcome"], place)
            row[outcome] = int(stated[outcome].sum())
            row |= self._ratio(f"{outcome}_share", mine, came_to, ones)
            row[f"{outcome}_share"] = row[outcome] / len(mine) if len(mine) else np.nan
            if place < 2 and self._attacked:
                caused = came_to.astype(np.float64) - reaches(mine["twin_outcome"], place)
                row |= self._ratio(f"{outcome}_caused_share", mine, caused, ones)
        return row

    @staticmethod
    def _rows(table: pd.DataFrame, defence: str) -> pd.DataFrame:
        return table[table["defence"] == defence]

    def _ratio(self, name: str, mine: pd.DataFrame, part: Any, whole: Any) -> _Row:
        return self._figure(name, mine, [np.asarray(part), np.asarray(whole)], _quotient)

    def _figure(self, name: str, mine: pd.DataFrame, columns: Sequence[Any], of: Callable[[Floats], Figures]) -> _Row:
        """Return a figure of sums over vehicles, with its interval."""
        values = np.stack([np.asarray(column, np.float64) for column in columns], axis=1)
        total = of(values.sum(axis=0))
        if not total.known:
            return {f"{name}{end}": np.nan for end in ("", "_lo", "_hi")}
        runs = pd.factorize(mine["scenario"])[0].astype(np.int32)
        key = f"{self._label}/{len(mine)}"
        if key not in self._weights or not np.array_equal(self._weights[key][1], runs):
            self._weights[key] = self._bootstrap.weights(self._label, runs), runs
        resampled = of(np.einsum("bv,vc->bc", self._weights[key][0], values))
        low, high = metrics.percentile_interval(resampled, self._bootstrap.confidence)
        return {name: float(total.value), f"{name}_lo": float(cells(low)), f"{name}_hi": float(cells(high))}


def reaches(outcome: "pd.Series[Any]", place: int) -> Flags:
    """Return whether the worst outcome is that of a place in `OUTCOMES`, or implies it: worse than out of lane does."""
    worst = outcome.to_numpy(object)
    implied = OUTCOMES[place:] if place < 2 else OUTCOMES[place : place + 1]
    return np.isin(worst, implied)


def _quotient(sums: Floats) -> Figures:
    return metrics.ratio(sums[..., 0], sums[..., 1])


def _rmse(sums: Floats) -> Figures:
    return metrics.rmse(sums[..., 0], sums[..., 1])


_SCORES: dict[str, Callable[[Floats], Figures]] = {
    "precision": lambda sums: metrics.precision(sums[..., 0], sums[..., 1], sums[..., 2]),
    "recall": lambda sums: metrics.recall(sums[..., 0], sums[..., 2]),
    "f1": lambda sums: metrics.f1(sums[..., 0], sums[..., 1], sums[..., 2]),
}
