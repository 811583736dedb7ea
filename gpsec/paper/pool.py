"""Figures of events pooled over runs, computed from CSV tables alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints
from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import Figures
from gpsec.outcomes.state import LARGEST
from gpsec.outcomes.tables import read_table
from gpsec.types.points import without_rate

BOOTSTRAP = Bootstrap(seed=2026, replicates=2000, confidence=0.95)

_SAMPLES = ["true_positives", "false_positives", "false_negatives"]
ERRORS = ("rmse_x_m", "rmse_y_m", "rmse_xy_m", "rmse_cross_track_m", "rmse_along_track_m")


@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval (bootstrap of runs, then vehicles) and the number of events behind it."""

    value: float | None
    low: float | None
    high: float | None
    n: int


def read_runs(folders: Sequence[Path], table: str) -> pd.DataFrame:
    """Return a table of several runs, one after the other; `run` names the run of each row.

    All detectors of a run here have one false-alarm rate, which names are therefore without.
    """
    parts = [named_plainly(read_table(folder, table)).assign(run=folder.name) for folder in folders]
    return pd.concat(parts, ignore_index=True)


def named_plainly(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of a run whose detectors, defences and columns are without the false-alarm rate."""
    named = {name: table[name].map(without_rate) for name in ("detector", "defence") if name in table}
    return table.assign(**named).rename(columns=without_rate)


def of_detector(events: pd.DataFrame, detector: str, attack: str) -> pd.DataFrame:
    """Return the events of an attack for one detector, one row each, however many defences use it."""
    mine = events[(events["detector"] == detector) & (events["attack"] == attack)]
    return mine[mine["response"] == mine["response"].iloc[0]] if len(mine) else mine


def of_defence(events: pd.DataFrame, defence: str, attack: str) -> pd.DataFrame:
    """Return the events of an attack under one defence."""
    return events[(events["defence"] == defence) & (events["attack"] == attack)]


def detection(events: pd.DataFrame) -> dict[str, Estimate]:
    """Return precision, recall, F1 and mean delay of the events of one detector, and the share it saw."""
    delay = events["detection_delay_s"].fillna(0.0)
    columns = [*(events[name] for name in _SAMPLES), delay, events["detected"]]
    return _estimates(
        _table(columns),
        {
            "precision": lambda s: metrics.precision(s[..., 0], s[..., 1], s[..., 2]),
            "recall": lambda s: metrics.recall(s[..., 0], s[..., 2]),
            "f1": _f1,
            "delay_mean_s": lambda s: metrics.ratio(s[..., 3], s[..., 4]),
            "detected_share": lambda s: metrics.ratio(s[..., 4], s[..., 5]),
        },
        _runs(events),
    )


def f1_lead(mine: pd.DataFrame, others: Sequence[pd.DataFrame]) -> Estimate:
    """Return the F1 of a detector minus that of the best of `others` on the same events, resampled in pairs."""
    same = ["run", "vehicle_id"]
    frames = [frame.sort_values(same) for frame in (mine, *others)]
    if any(frame[same].to_numpy().tolist() != frames[0][same].to_numpy().tolist() for frame in frames):
        raise ValueError("detectors can only be compared on the same events")
    sums = np.concatenate([_table([frame[name] for name in _SAMPLES]) for frame in frames], axis=1)

    def lead(s: Floats) -> Figures:
        scores = [_f1(s[..., 4 * k : 4 * k + 3]) for k in range(len(frames))]
        best = np.max([score.value for score in scores[1:]], axis=0)
        return Figures(scores[0].value - best, scores[0].known)

    return _estimate(sums, lead, _runs(frames[0]))


def localization(events: pd.DataFrame) -> dict[str, Estimate]:
    """Return the errors of the events of one defence: pooled, √(Σ rmse² · seconds / Σ seconds), and average maxima.

    An average maximum is the mean over events of the largest error of each.
    """
    seconds = events["attack_seconds"]
    squares = [events[name].fillna(0.0) ** 2 * seconds for name in ERRORS]
    sums = _table([*squares, seconds, *(events[name].fillna(0.0) for name in LARGEST), seconds > 0.0])

    def error(place: int) -> Callable[[Floats], Figures]:
        return lambda s: metrics.rmse(s[..., place], s[..., len(ERRORS)])

    def largest(place: int) -> Callable[[Floats], Figures]:
        return lambda s: metrics.ratio(s[..., len(ERRORS) + 1 + place], s[..., len(ERRORS) + 1 + len(LARGEST)])

    pooled = {name: error(place) for place, name in enumerate(ERRORS)}
    return _estimates(
        sums, pooled | {f"average_{name}": largest(place) for place, name in enumerate(LARGEST)}, _runs(events)
    )


def share(events: pd.DataFrame, chosen: pd.Series) -> Estimate:
    """Return the share of the events for which `chosen` holds."""
    return _estimate(_table([chosen]), lambda s: metrics.ratio(s[..., 0], s[..., 1]), _runs(events))


def rate(part: pd.Series, of: pd.Series) -> Estimate:
    """Return Σ part / Σ of, over the vehicles of one run."""
    one = np.zeros(len(part), np.int32)
    return _estimate(_table([part, of]), lambda s: metrics.ratio(s[..., 0], s[..., 1]), one)


def false_alarms(vehicles: pd.DataFrame, detector: str) -> Estimate:
    """Return the false alarms of a detector for each hour of vehicles without an attack."""
    mine = vehicles[(vehicles["detector"] == detector) & (vehicles["attack"] == "none")]
    mine = mine[mine["response"] == mine["response"].iloc[0]]
    sums = _table([mine["false_alarms"], mine["vehicle_seconds"] / 3600.0])
    found = _estimate(sums, lambda s: metrics.ratio(s[..., 0], s[..., 1]), _runs(mine))
    if found.value != 0.0:
        return found
    bound = metrics.poisson_bound_of_none(sums[:, 1].sum(keepdims=True), BOOTSTRAP.confidence)
    return Estimate(0.0, 0.0, float(bound.value[0]), found.n)


def _f1(sums: Floats) -> Figures:
    return metrics.f1(sums[..., 0], sums[..., 1], sums[..., 2])


def _table(columns: Sequence[pd.Series]) -> Floats:
    """Return (V, C + 1) values of each vehicle; the last column counts it."""
    values = [column.to_numpy(np.float64) for column in columns]
    return np.stack([*values, np.ones(len(values[0]))], axis=1)


def _runs(table: pd.DataFrame) -> Ints:
    """Return the number of the run of each row."""
    return pd.factorize(table["run"])[0].astype(np.int32)


def _estimates(
    per_vehicle: Floats, figures: Mapping[str, Callable[[Floats], Figures]], runs: Ints
) -> dict[str, Estimate]:
    """Return figures of (V, C) sums of each vehicle, which is of (V,) `runs`, all from the same resampled fleets."""
    n = len(per_vehicle)
    total = per_vehicle.sum(axis=0, keepdims=True)
    resampled = np.einsum("bv,vc->bc", BOOTSTRAP.weights("paper", runs), per_vehicle)
    found = {}
    for name, of in figures.items():
        value, known = of(total)
        if not known[0]:
            found[name] = Estimate(None, None, None, n)
            continue
        low, high = metrics.percentile_interval(of(resampled), BOOTSTRAP.confidence)
        found[name] = Estimate(float(value[0]), float(low.value), float(high.value), n)
    return found


def _estimate(per_vehicle: Floats, of: Callable[[Floats], Figures], runs: Ints) -> Estimate:
    return _estimates(per_vehicle, {"": of}, runs)[""]
