"""How bad plans are for a defence: the score of a search, and the figures of its best on what it has not seen."""

from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import percentile_interval, ratio
from gpsec.outcomes.state import OUTCOMES
from gpsec.types.constants import UNDEFENDED

# Each with the column of a judged plan that says it.
JUDGED_BY = {
    "out_of_lane": "out_of_lane_caused_share",
    "line_touched": "line_touched_caused_share",
    "undetected": "max_undetected_deviation_median_m",
}
OBJECTIVES = tuple(JUDGED_BY)
# What tells plans of one score apart: the mean of their largest errors across, in metres.
_TIE_PER_M, _MOST_M = 1e-3, 10.0
_REPLICATES = 1000
_CONFIDENCE = 0.95


def harm(events: pd.DataFrame, defence: str, objective: str) -> float:
    """Return how bad a plan is for a defence, from its events; the worse, the higher."""
    mine = events[events["defence"] == defence]
    if not len(mine):
        return 0.0
    tie = float(mine["max_cross_track_m"].fillna(0.0).clip(upper=_MOST_M).mean()) * _TIE_PER_M
    if objective == "undetected":
        return float(mine["max_undetected_deviation_m"].fillna(0.0).median()) + tie
    return float(np.mean(caused(mine, objective))) + tie


def caused(events: pd.DataFrame, outcome: str) -> Floats:
    """Return (n,) 1 where an event came to an outcome and its benign twin did not, -1 the other way round, else 0."""
    implied = OUTCOMES[OUTCOMES.index(outcome) :]
    reached, of_twin = (np.isin(events[name].to_numpy(object), implied) for name in ("outcome", "twin_outcome"))
    return reached.astype(np.float64) - of_twin


def judged_figures(events: pd.DataFrame, defence: str, seed: int) -> dict[str, Any]:
    """Return the figures of one plan over several runs, numbered by `run`; intervals are of runs, then vehicles."""
    mine = events[events["defence"] == defence]
    runs = mine["run"].to_numpy(np.int32)
    weights = Bootstrap(seed, _REPLICATES, _CONFIDENCE).weights("search", runs)
    row: dict[str, Any] = {"n_runs": mine["run"].nunique(), "n_vehicles": len(mine)}
    shares = {
        "out_of_lane_caused_share": caused(mine, "out_of_lane"),
        "line_touched_caused_share": caused(mine, "line_touched"),
        "undefended_out_of_lane_caused_share": caused(events[events["defence"] == UNDEFENDED], "out_of_lane"),
        "detected_share": mine["detected"].to_numpy(np.float64),
    }
    for name, values in shares.items():
        row[name] = float(values.mean()) if len(values) else np.nan
        low, high = percentile_interval(ratio(weights @ values, weights.sum(axis=1)), _CONFIDENCE)
        for end, bound in (("_lo", low), ("_hi", high)):
            row[name + end] = float(bound.value) if bound.known else np.nan
    return row | {"max_undetected_deviation_median_m": mine["max_undetected_deviation_m"].median()}
