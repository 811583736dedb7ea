"""The columns of every table, and what is in them; ``results/README.md`` says what they mean."""

import csv
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.arrays import Flags
from gpsec.core.errors import GpsecError, shown
from gpsec.outcomes.lanes import JUDGED_PLACES, PHASES
from gpsec.outcomes.places import ATTACK_BEGAN, DETECTED, LEFT_LANE
from gpsec.outcomes.state import AVERAGE_MAX, LARGEST, OUTCOMES
from gpsec.outcomes.street_names import PLACE
from gpsec.outcomes.tables import POOLED_PREFIX, read_table

_GROUP = ("scenario", "profile", "attack")
_OWNER = ("scenario", "seed", "vehicle_id", "vehicle_type", *_GROUP[1:], "defence", "detector", "response")
_WHEN = ("start_", "detection_", "departure_")
_REACHED = tuple(f"reached_{outcome}" for outcome in OUTCOMES)
_TWIN = ("twin_rmse_xy_m", "twin_rmse_cross_track_m")
_RMSE = ("rmse_x_m", "rmse_y_m", "rmse_xy_m", "rmse_cross_track_m", "rmse_along_track_m")


def _bounded(*names: str) -> tuple[str, ...]:
    """Return columns with those of their intervals."""
    return tuple(f"{name}{end}" for name in names for end in ("", "_lo", "_hi"))


# Of the undefended vehicle, before any alarm.
_UNSEEN = tuple(f"{outcome}_unseen" for outcome in OUTCOMES[:2])
COLUMNS = {
    "detection": (
        *_GROUP,
        *("detector", "rate", "n_events", *_bounded("precision", "recall", "f1", "delay_mean_s")),
        *("delay_median_s", "delay_p95_s", *_bounded("detected_share"), "false_positive_rate"),
        *(*_bounded("detected_not_twin_share"), "n_line_events", *_bounded("seen_before_line_share")),
        *_bounded("alarm_ends_after_mean_s"),
        *(*_bounded("false_alarms_per_vehicle_hour"), "vehicle_hours", "roc_auc", "pr_auc", "threshold"),
        *("threshold_from", "matched_threshold", "matched_recall", "matched_detected_share"),
    ),
    "localization": (
        *(*_GROUP, "defence", "n_events", "n_vehicles", *_bounded(*_RMSE)),
        *("max_cross_track_m", *AVERAGE_MAX, *_TWIN),
    ),
    "safety": (
        *(*_GROUP, "defence", "n_vehicles", *OUTCOMES),
        *_bounded(*(f"{outcome}_share" for outcome in OUTCOMES)),
        *_bounded("line_touched_caused_share", "out_of_lane_caused_share"),
        *("note", *_bounded("isolated_minutes_per_vehicle_hour")),
    ),
    "events": (
        *_OWNER,
        *("start_s", "end_s", "attack_seconds", "cut_short", "in_alarm_at_start", "detected", "detected_not_twin"),
        *("detection_delay_s", "alarm_ends_after_s"),
        *("deviation_at_detection_m", "max_undetected_deviation_m", "max_undetected_deviation_s"),
        *_UNSEEN,
        *("true_positives", "false_positives", "false_negatives", "true_negatives"),
        *("isolated_share", "time_to_retrust_s", *_RMSE, "max_cross_track_m", *LARGEST),
        *("outcome", "time_to_outcome_s", "time_to_line_s", "twin_outcome", "twin_rmse_xy_m"),
        *(*_REACHED, *(f"time_to_{outcome}_s" for outcome in OUTCOMES[1:])),
        *(f"{when}{column}" for when in _WHEN for column in PLACE),
    ),
    "vehicles": (
        *_OWNER,
        *("depart_s", "arrive_s", "vehicle_seconds", "scored_seconds", "isolated_seconds", "alarms", "false_alarms"),
        *("rmse_xy_m", "max_cross_track_m", "outcome"),
    ),
    "curves": (*_GROUP, "detector", "threshold", "false_positive_rate", "recall", "precision"),
    "error_bands": (
        *(*_GROUP, "defence", "time_s", "n_vehicles"),
        *(f"{way}_track_{part}_m" for way in ("cross", "along") for part in ("p05", "median", "p95")),
    ),
    "places": (*_OWNER[:4], *_GROUP[1:], "what", "by", "time_s", "x_m", "y_m", "lon_deg", "lat_deg", *PLACE),
    "streets": (
        *(*_GROUP, "edge", "defence", "entries", "vehicle_seconds", "detections", "departures"),
        *(*_bounded("departures_per_vehicle_hour"), "isolated_seconds"),
    ),
    "association": (
        *(*_GROUP, "phase", "association", "steps", "unknown_share", "unmatched_share"),
        *(f"{place}_{what}" for place in JUDGED_PLACES for what in ("steps", "right_share")),
        *("lane_changes", "right_within_100_ms_share", "right_within_500_ms_share"),
    ),
}
_STREETS = {f"{when}{column}" for when in ("", *_WHEN) for column in ("edge", "lane")}
TEXTS = {
    *_OWNER,
    *_STREETS,
    "rate",
    "threshold_from",
    "note",
    "outcome",
    "twin_outcome",
    "what",
    "by",
    "phase",
    "association",
} - {"seed"}
FLAGS = {"cut_short", "in_alarm_at_start", "detected", "detected_not_twin", *_REACHED, *_UNSEEN}
# Those that are empty where there was no such place.
_OPTIONAL_FLAGS = {f"{when}in_junction" for when in ("", *_WHEN)}
COUNTS = {
    *(
        "seed",
        "n_events",
        "n_vehicles",
        "n_line_events",
        "alarms",
        "false_alarms",
        "entries",
        "detections",
        "departures",
    ),
    *("steps", "lane_changes", *(f"{place}_steps" for place in JUDGED_PLACES)),
    *("true_positives", "false_positives", "false_negatives", "true_negatives"),
}
# Texts that are one of a few.
_KNOWN = {
    "threshold_from": {"counted", "model", "fixed"},
    "outcome": {"none", *OUTCOMES},
    "twin_outcome": {"none", *OUTCOMES},
    "what": {ATTACK_BEGAN, DETECTED, LEFT_LANE},
    "phase": {*PHASES},
}
# What may be empty of the texts. Numbers may be empty but for these.
_OPTIONAL = {"by", "rate", "note", *_STREETS}
_REQUIRED = {"start_s", "end_s", "depart_s", "time_s", "lon_deg", "lat_deg", "vehicle_hours", "vehicle_seconds"}


def read_checked(folder: Path, name: str) -> pd.DataFrame:
    """Return a table of a run that anybody may have edited; columns beyond its own are kept as they are.

    Texts are str, flags bool, counts int64 and numbers float64, NaN where they are empty.

    Raises:
        GpsecError: it is missing or no such table, or a cell holds something else than it should.
    """
    path, frame = folder / f"{name}.csv", read_rows(folder, name)
    for column in COLUMNS[name.removeprefix(POOLED_PREFIX)]:
        if column not in frame:
            raise GpsecError(f"{path}: expected a table of a finished run, found no column '{column}'")
        frame[column] = _checked(path, column, frame[column])
    return frame


def read_rows(folder: Path, name: str) -> pd.DataFrame:
    """Return a table of a run, whose cells may hold anything.

    Raises:
        GpsecError: it is missing, or no table.
    """
    path = folder / f"{name}.csv"
    try:
        _check_lines(path)
        return read_table(folder, name)
    except FileNotFoundError:
        raise GpsecError(
            f"{folder}: expected the tables of a run, found no {path.name}; a run of an older version lacks some, run"
            " it again"
        ) from None
    except OSError as error:
        raise GpsecError(f"{path}: cannot be read: {error.strerror or shown(error)}") from None
    except (ValueError, csv.Error, OverflowError) as error:
        said = shown(str(error).partition("\n")[0])
        raise GpsecError(f"{path}: expected a table of a finished run, found other data ({said})") from None


def _check_lines(path: Path) -> None:
    """Refuse rows that are longer or shorter than the first, which pandas would take for others."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = csv.reader(file, strict=True)
        header = next(rows, [])
        if len(set(header)) < len(header):
            raise ValueError("a column that is there twice")
        for row in rows:
            if row and len(row) != len(header):
                raise ValueError(f"{len(row)} cells in line {rows.line_num}, {len(header)} columns")


def _checked(path: Path, column: str, values: "pd.Series[Any]") -> "pd.Series[Any]":
    if column in TEXTS:
        return as_texts(path, column, values, _KNOWN.get(column), optional=column in _OPTIONAL)
    if column in _OPTIONAL_FLAGS:
        wrong = ~(values.isin([True, False]) | values.isna()).to_numpy()
        if wrong.any():
            raise _error(path, column, "True, False or nothing", wrong, values)
        return values.astype("boolean")
    if column in FLAGS:
        return as_flags(path, column, values)
    # Outcomes are left out where they say nothing.
    whole = column in COUNTS or column in OUTCOMES
    numbers = as_numbers(path, column, values, required=column in _REQUIRED | COUNTS, whole=whole)
    counted = column in COUNTS or (column in OUTCOMES and not numbers.isna().any())
    return numbers.astype(np.int64) if counted else numbers


def as_texts(
    path: Path, column: str, values: "pd.Series[Any]", known: Collection[str] | None = None, *, optional: bool = False
) -> "pd.Series[Any]":
    """Return a column of texts, each of those that are `known`; `optional` ones may be empty."""
    empty = values.isna()
    if not optional and empty.any():
        raise _error(path, column, "a text", empty.to_numpy(), values)
    if known is not None and not values.isin(known).all():
        raise _error(path, column, f"one of {', '.join(sorted(known))}", ~values.isin(known).to_numpy(), values)
    return values


def as_flags(path: Path, column: str, values: "pd.Series[Any]") -> "pd.Series[Any]":
    """Return a column of flags."""
    wrong = ~values.isin([True, False]).to_numpy() if values.dtype != np.bool_ else np.zeros(len(values), np.bool_)
    if wrong.any():
        raise _error(path, column, "True or False", wrong, values)
    return values.astype(np.bool_)


def as_numbers(
    path: Path, column: str, values: "pd.Series[Any]", *, required: bool, whole: bool = False
) -> "pd.Series[Any]":
    """Return a column of numbers, NaN where it is empty, which not `required` ones may be; `whole` ones are counts."""
    empty = values.isna().to_numpy()
    numbers = pd.to_numeric(values.astype(object), errors="coerce").astype(np.float64)
    wrong = (numbers.isna().to_numpy() & ~empty) | np.isinf(numbers.to_numpy())
    if required:
        wrong |= empty
    if whole:
        wrong |= ~empty & ~((numbers >= 0) & (numbers < 2**53) & (numbers % 1 == 0)).to_numpy()
    if wrong.any():
        raise _error(path, column, "a count" if whole and required else "a number", wrong, values)
    return numbers


def _error(path: Path, column: str, expected: str, wrong: Flags, values: "pd.Series[Any]") -> GpsecError:
    row = int(np.flatnonzero(wrong)[0])
    found = values.iloc[row]
    said = "an empty cell" if pd.isna(found) else f"'{shown(found)}'"
    return GpsecError(f"{path}: column '{column}', row {row + 1}: expected {expected}, found {said}")
