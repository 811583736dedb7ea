"""The tables with a row for every vehicle: `events.csv` and `vehicles.csv`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.metrics import Figures, Numbers, rmse
from gpsec.outcomes.state import (
    ALL,
    ALONG,
    ATTACK,
    CROSS,
    FALSE,
    FN,
    FP,
    LARGEST,
    LIFE,
    LINE_TOUCHED,
    OUT_OF_LANE,
    OUTCOMES,
    TN,
    TP,
    X,
    Y,
    worst,
)
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.study import Study

# Columns of scored samples, by what they are.
_SAMPLES = {"true_positives": TP, "false_positives": FP, "false_negatives": FN, "true_negatives": TN}


def cells(figures: Figures) -> Floats:
    """Return figures as pandas holds them, NaN where undefined; they are written as empty cells."""
    return np.where(figures.known, figures.value, np.nan)


def only(value: Numbers, known: Flags) -> Floats:
    """Return `value` as pandas holds it where `known`, an empty cell elsewhere."""
    return np.where(known, value, np.nan)


def error_columns(squared_m2: Floats, samples: Numbers) -> dict[str, Figures]:
    """Return the five RMSE columns of (…, 4) sums of squared errors over (…,) samples."""
    return {
        "rmse_x_m": rmse(squared_m2[..., X], samples),
        "rmse_y_m": rmse(squared_m2[..., Y], samples),
        "rmse_xy_m": rmse(squared_m2[..., X] + squared_m2[..., Y], samples),
        "rmse_cross_track_m": rmse(squared_m2[..., CROSS], samples),
        "rmse_along_track_m": rmse(squared_m2[..., ALONG], samples),
    }


def events_table(
    study: Study, tracks: ClosedTracks, streets: Streets, scenario: str, seed: int, origin_s: float
) -> pd.DataFrame:
    """Return one row for every attacked vehicle, plan and defence."""
    events = tracks.events()
    state = events.state
    k = study.detector_of
    step_s = study.step_s
    start = events.start_step[:, None]
    end = events.last_step()
    detection = state.detection_step[:, k]
    detected = detection >= 0
    attacked = state.steps[:, ATTACK]
    outcome, outcome_step = worst(state.first_step)
    table = _identity(study, events, scenario, seed)
    table |= {
        "start_s": _spread(origin_s + events.start_step * step_s, study),
        "end_s": _spread(origin_s + end * step_s, study),
        "attack_seconds": _spread(attacked * step_s, study),
        "cut_short": _spread(events.end_step < 0, study),
        "in_alarm_at_start": state.in_alarm_at_start[:, k],
        "detected": detected,
        "detected_not_twin": detected & ~state.twin_in_alarm[:, k],
        "detection_delay_s": only((detection - start) * step_s, detected),
        "alarm_ends_after_s": only((state.tail_end_step[:, k] - end[:, None]) * step_s, state.tail_end_step[:, k] >= 0),
        "deviation_at_detection_m": only(state.deviation_m, detected),
        "max_undetected_deviation_m": only(state.undetected_m[:, k], (attacked > 0)[:, None]),
        "max_undetected_deviation_s": only(
            (state.undetected_step[:, k] - start) * step_s, state.undetected_step[:, k] >= 0
        ),
        **unseen_columns(state.first_step[:, 0], detection),
        **{name: state.counts[:, k, kind] for name, kind in _SAMPLES.items()},
        "isolated_share": cells(_share(state.isolated_steps[..., ATTACK], attacked)),
        "time_to_retrust_s": only(
            (state.retrust_step - end[:, None]) * step_s,
            (state.retrust_step >= 0) & (state.isolated_steps[..., ATTACK] > 0),
        ),
    }
    samples = attacked[:, None] + np.zeros(len(k), np.int32)
    errors = error_columns(state.squared_m2[:, :, ATTACK], samples)
    of_twin = error_columns(state.twin_squared_m2, samples)
    line = state.first_step[..., LINE_TOUCHED]
    table |= {name: cells(figures) for name, figures in errors.items()}
    table |= {
        "max_cross_track_m": only(state.max_cross_m[:, :, ATTACK], (attacked > 0)[:, None]),
        **{name: only(state.largest_m[:, :, part], (attacked > 0)[:, None]) for part, name in enumerate(LARGEST)},
        "outcome": _outcome_names(outcome),
        "time_to_outcome_s": only((outcome_step - start) * step_s, outcome >= 0),
        "time_to_line_s": only((line - start) * step_s, line >= 0),
        "twin_outcome": _outcome_names(worst(state.twin_first_step)[0]),
        "twin_rmse_xy_m": cells(of_twin["rmse_xy_m"]),
    }
    first = state.first_step
    table |= {f"reached_{name}": first[..., place] >= 0 for place, name in enumerate(OUTCOMES)}
    table |= {
        f"time_to_{name}_s": only((first[..., place] - start) * step_s, first[..., place] >= 0)
        for place, name in enumerate(OUTCOMES)
        if place != LINE_TOUCHED
    }
    left = np.where(first[..., OUT_OF_LANE] >= 0, state.departed_lane, -1)
    table |= streets.columns("start_", *(_spread(values, study) for values in (state.start_lane, state.start_mps)))
    table |= streets.columns("detection_", np.where(detected, state.detected_lane[:, k], -1), state.detected_mps[:, k])
    table |= streets.columns("departure_", left, state.departed_mps)
    return _frame(table)


def unseen_columns(first_step: Ints, detection_step: Ints) -> dict[str, Flags]:
    """Return whether (T, 4) outcomes of the undefended vehicle came before (T, n) first alarms, if there were any.

    There is a column for each of the first two outcomes.
    """
    reached = first_step[:, None, :2]
    alarm = detection_step[..., None]
    unseen = (reached >= 0) & ((alarm < 0) | (reached < alarm))
    return {f"{name}_unseen": unseen[..., place] for place, name in enumerate(OUTCOMES[:2])}


def vehicles_table(study: Study, tracks: ClosedTracks, scenario: str, seed: int) -> pd.DataFrame:
    """Return one row for every vehicle, plan and defence; plans that attack it, and none for every vehicle."""
    tracks = tracks.take((tracks.plan == 0) | tracks.state.in_event)
    state = tracks.state
    k = study.detector_of
    settled = state.steps[:, LIFE]
    squared = state.squared_m2[:, :, LIFE]
    outcome, _ = worst(state.first_step)
    table = _identity(study, tracks, scenario, seed)
    table |= {
        "depart_s": _spread(tracks.depart_s, study),
        "arrive_s": _spread(only(tracks.arrive_s, tracks.arrived), study),
        "vehicle_seconds": _spread(settled * study.step_s, study),
        "scored_seconds": state.counts[:, k, TP : TN + 1].sum(axis=2) * study.sample_s,
        "isolated_seconds": state.isolated_steps[..., LIFE] * study.step_s,
        "alarms": state.onsets[:, k, ALL],
        "false_alarms": state.onsets[:, k, FALSE],
        "rmse_xy_m": cells(rmse(squared[..., X] + squared[..., Y], settled[:, None] + np.zeros(len(k)))),
        "max_cross_track_m": only(state.max_cross_m[:, :, LIFE], (settled > 0)[:, None]),
        "outcome": _outcome_names(outcome),
    }
    return _frame(table)


def _identity(study: Study, tracks: ClosedTracks, scenario: str, seed: int) -> dict[str, Any]:
    shape = (len(tracks), len(study.defences))
    return {
        "scenario": np.full(shape, scenario, object),
        "seed": np.full(shape, seed),
        "vehicle_id": _spread(tracks.vehicle_id.astype(object), study),
        "vehicle_type": _spread(tracks.vehicle_type.astype(object), study),
        "profile": _spread(np.array(study.profiles, object)[tracks.profile], study),
        "attack": _spread(np.array(study.plans, object)[tracks.plan], study),
        "defence": np.broadcast_to(np.array(study.defence_names, object), shape),
        "detector": np.broadcast_to(np.array([detector for detector, _ in study.defences], object), shape),
        "response": np.broadcast_to(np.array([response for _, response in study.defences], object), shape),
    }


def _spread(values: Any, study: Study) -> Any:
    """Return (T, D) copies of (T,) values."""
    return np.repeat(np.asarray(values)[:, None], len(study.defences), axis=1)


def _share(part: Ints, whole: Ints) -> Figures:
    known = np.broadcast_to((whole > 0)[:, None], part.shape)
    return Figures(part / np.maximum(whole, 1)[:, None], known)


def _outcome_names(outcome: Ints) -> Any:
    return np.array(["none", *OUTCOMES], object)[outcome + 1]


def _frame(table: Mapping[str, Any]) -> pd.DataFrame:
    return pd.DataFrame({name: np.asarray(values).reshape(-1) for name, values in table.items()})
