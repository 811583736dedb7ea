"""The impact of attacks: how far a vehicle gets off its lane before anybody notices, at which rate of false alarms.

Urbina et al., "Limiting the Impact of Stealthy Attacks on Industrial Control Systems" (CCS 2016): detectors are
compared by the damage of an undetected attack, set against the time between their false alarms.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints
from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import Figures
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.records import cells
from gpsec.outcomes.tables import read_table, whole, write_frame

IMPACT = "impact"
GONE_UNSEEN = ("line_touched", "out_of_lane")
_TOLD = "told"
_SEED = 2026
_Row = dict[str, Any]


def impact_table(tables: Mapping[str, pd.DataFrame], bootstrap: Bootstrap) -> pd.DataFrame:
    """Return one row for every scenario, profile, attack and detector that a defence heeds, over all seeds.

    Args:
        tables: `events`, `vehicles` and `detection` of one or more runs.
        bootstrap: makes the intervals of scenarios that were run with several seeds, of runs and then vehicles. Of one
            run they are Wilson's of shares, and distribution-free of the median.
    """
    events, vehicles, stated = tables["events"], tables["vehicles"], tables["detection"]
    rates = stated.drop_duplicates("detector").set_index("detector")["rate"]
    detectors = [name for name in dict.fromkeys(events["detector"]) if name != _TOLD]
    heeded = events.drop_duplicates("detector").set_index("detector")["defence"]
    bases = {name: table["scenario"].map(base_name) for name, table in tables.items()}
    rows: list[_Row] = []
    for (base, profile), group in events.groupby([bases["events"], "profile"], sort=False, observed=True):
        honest = vehicles[(bases["vehicles"] == base) & (vehicles["profile"] == profile)]
        honest = honest[honest["attack"] == "none"]
        of_group = stated[(bases["detection"] == base) & (stated["profile"] == profile)]
        benign = _Vehicles(honest, heeded, bootstrap, f"{profile}/none")
        alarms = {name: benign.false_alarms(name, of_group[of_group["detector"] == name]) for name in detectors}
        for attack, mine in group.groupby("attack", sort=False, observed=True):
            head = {"scenario": base, "profile": profile, "attack": attack}
            attacked = _Vehicles(mine, heeded, bootstrap, f"{profile}/{attack}")
            rows += [
                head | {"detector": name, "rate": rates.get(name, "")} | attacked.seen(name) | alarms[name]
                for name in detectors
            ]
    return pd.DataFrame(rows, columns=IMPACT_COLUMNS)


def write_impact(folder: Path) -> None:
    """Write the table of the runs in a folder beside their others."""
    tables = {name: read_table(folder, name) for name in ("events", "vehicles", "detection")}
    with whole(folder / f"{IMPACT}.csv") as partial:
        write_frame(impact_table(tables, Bootstrap(_SEED)), partial)


def _bounded(name: str) -> list[str]:
    return [name, f"{name}_lo", f"{name}_hi"]


_MEDIAN, _RATE = "max_undetected_deviation_median_m", "false_alarms_per_vehicle_hour"
IMPACT_COLUMNS = [
    *("scenario", "profile", "attack", "detector", "rate", "n_runs", "n_events"),
    *_bounded(_RATE),
    *_bounded("detected_share"),
    *_bounded(_MEDIAN),
    *("max_undetected_deviation_p95_m", "max_undetected_deviation_median_s"),
    *(column for name in GONE_UNSEEN for column in _bounded(f"{name}_unseen_share")),
]


class _Vehicles:
    """Some vehicles of one or more runs, with a row for each defence."""

    def __init__(self, rows: pd.DataFrame, heeded: "pd.Series[Any]", bootstrap: Bootstrap, label: str) -> None:
        """Take the rows; `heeded` is a defence of each detector."""
        self._bootstrap = bootstrap
        self._of = {name: rows[rows["defence"] == defence] for name, defence in heeded.items()}
        # The same vehicles for all defences, in the same order.
        runs = pd.factorize(next(iter(self._of.values()))["scenario"])[0].astype(np.int32)
        self._runs = len(np.unique(runs))
        self._weights = bootstrap.weights(label, runs) if self._runs > 1 else None

    def seen(self, detector: str) -> _Row:
        """Return what a detector has seen of an attack, and when."""
        rows = self._of[detector]
        off_m = rows["max_undetected_deviation_m"].to_numpy(np.float64)
        late_s = rows["max_undetected_deviation_s"].to_numpy(np.float64)
        row: _Row = {"n_runs": self._runs, "n_events": len(rows)}
        row |= self._share("detected_share", rows["detected"].to_numpy(np.float64))
        row |= self._median(_MEDIAN, off_m[~np.isnan(off_m)], ~np.isnan(off_m))
        row["max_undetected_deviation_p95_m"] = _quantile(off_m, 0.95)
        row["max_undetected_deviation_median_s"] = _quantile(late_s, 0.5)
        for name in GONE_UNSEEN:
            row |= self._share(f"{name}_unseen_share", rows[f"{name}_unseen"].to_numpy(np.float64))
        return row

    def false_alarms(self, detector: str, stated: pd.DataFrame) -> _Row:
        """Return the false alarms of an hour that were achieved: of one run, as its rows of detection.csv have them."""
        if self._weights is None:
            return {str(name): value for name, value in stated[_bounded(_RATE)].iloc[0].items()}
        alarms = self._of[detector]["false_alarms"].to_numpy(np.float64)
        hours = self._of[detector]["vehicle_seconds"].to_numpy(np.float64) / 3600.0
        row = {_RATE: float(cells(metrics.ratio(alarms.sum(), hours.sum())))}
        if not alarms.any():  # fleets that are drawn from vehicles without an alarm have none either
            bound = metrics.poisson_bound_of_none(hours.sum(), self._bootstrap.confidence)
            return row | {f"{_RATE}_lo": 0.0, f"{_RATE}_hi": float(cells(bound))}
        return row | self._interval(_RATE, metrics.ratio(self._weights @ alarms, self._weights @ hours))

    def _share(self, name: str, flags: Floats) -> _Row:
        found = metrics.ratio(flags.sum(), np.array(len(flags)))
        row = {name: float(cells(found))}
        if self._weights is not None:
            return row | self._interval(name, metrics.ratio(self._weights @ flags, self._weights.sum(axis=1)))
        low, high = metrics.wilson_interval(flags.sum(), np.array(len(flags)), self._bootstrap.confidence)
        return row | {f"{name}_lo": float(cells(low)), f"{name}_hi": float(cells(high))}

    def _median(self, name: str, values: Floats, known: Any) -> _Row:
        row = {name: _quantile(values, 0.5)}
        ranks = median_ranks(len(values), self._bootstrap.confidence)
        if self._weights is not None and len(values):
            return row | self._interval(name, weighted_medians(values, self._weights[:, known]))
        low, high = (np.nan, np.nan) if ranks is None else np.sort(values)[[*ranks]]
        return row | {f"{name}_lo": float(low), f"{name}_hi": float(high)}

    def _interval(self, name: str, drawn: Figures) -> _Row:
        low, high = metrics.percentile_interval(drawn, self._bootstrap.confidence)
        return {f"{name}_lo": float(cells(low)), f"{name}_hi": float(cells(high))}


def weighted_medians(values: Floats, weights: Floats) -> Figures:
    """Return (B,) medians of (V,) values of which each is there as often as (B, V) weights say."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[:, order], axis=1)
    total = below[:, -1]
    at: Ints = (below >= 0.5 * total[:, None]).argmax(axis=1)
    return Figures(values[order][at], total > 0.0)


def median_ranks(count: int, confidence: float) -> tuple[int, int] | None:
    """Return the ranks, from 0, of the values that hold the median of what `count` are drawn from; None for too few.

    By the binomial distribution, whatever that of the values is (Conover, Practical Nonparametric Statistics, 1999).
    """
    from scipy.special import bdtr

    outside = 2.0 * bdtr(np.arange(count // 2, dtype=np.float64), count, 0.5)
    enough = int(np.count_nonzero(outside <= 1.0 - confidence))
    return (enough - 1, count - enough) if enough else None


def _quantile(values: Floats, share: float) -> float:
    known = values[~np.isnan(values)]
    return float(np.quantile(known, share)) if len(known) else float("nan")
