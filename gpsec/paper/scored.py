"""Scores that were made without gpsec: files beside a dataset's, with a row for each track and step that is scored."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from gpsec.attacks.plans import NO_ATTACK
from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.errors import GpsecError, shown

SCORED_ROW = ("vehicle", "attack", "step")
SCORE = "score"
_LABELS = ("time_s", "settled", "attacked")


class ScoredRun(NamedTuple):
    """The scores of one run; R rows in the order of the steps, of tracks that are numbered by vehicle and plan.

    Attributes:
        vehicles: names of the V vehicles.
        plans: names of the P plans, the first without an attack.
        vehicle, plan: (M,) of each track.
        track, step: (R,) of each row.
        settled, attacked: (R,) as in `Tracks`.
        score: (R,) at least 0, NaN where the detector says nothing.
        step_s: length of a step.
    """

    vehicles: tuple[str, ...]
    plans: tuple[str, ...]
    vehicle: Ints
    plan: Ints
    track: Ints
    step: Ints
    settled: Flags
    attacked: Flags
    score: Floats
    step_s: float


def read_scored(data: Path, scores: Path) -> ScoredRun:
    """Return the rows of a file of a dataset with the scores that another file has of them.

    Raises:
        GpsecError: one of them is not what it should be.
    """
    rows = _read(data, [*SCORED_ROW, *_LABELS], "a file of a dataset")
    given = _read(scores, [*SCORED_ROW, SCORE], "scores")
    _check(scores, given)
    merged = rows.merge(given, on=list(SCORED_ROW), how="left", sort=False)
    unknown = len(given) - int(given.merge(rows[list(SCORED_ROW)], on=list(SCORED_ROW)).shape[0])
    if unknown:
        raise GpsecError(f"{scores}: {unknown} of {len(given)} rows are of no vehicle, attack and step of {data}")
    merged = merged.sort_values("step", kind="stable")
    vehicles = tuple(sorted(merged["vehicle"].unique()))
    plans = (NO_ATTACK, *sorted(set(merged["attack"]) - {NO_ATTACK}))
    who = merged["vehicle"].map({name: i for i, name in enumerate(vehicles)}).to_numpy(np.int64)
    what = merged["attack"].map({name: i for i, name in enumerate(plans)}).to_numpy(np.int64)
    tracks, track = np.unique(who * len(plans) + what, return_inverse=True)
    step = merged["step"].to_numpy(np.int32)
    return ScoredRun(
        vehicles=vehicles,
        plans=plans,
        vehicle=(tracks // len(plans)).astype(np.int32),
        plan=(tracks % len(plans)).astype(np.int32),
        track=track.astype(np.int32),
        step=step,
        settled=merged["settled"].to_numpy(np.bool_),
        attacked=merged["attacked"].to_numpy(np.bool_),
        score=merged[SCORE].to_numpy(np.float64),
        step_s=_step_s(data, merged["time_s"].to_numpy(np.float64), step),
    )


def _step_s(data: Path, time_s: Floats, step: Ints) -> float:
    if len(step) == 0 or step[-1] == step[0]:
        raise GpsecError(f"{data}: expected the rows of several steps, found one or none")
    return round(float((time_s[-1] - time_s[0]) / (step[-1] - step[0])), 6)


def _read(path: Path, columns: list[str], what: str) -> pd.DataFrame:
    if not path.is_file():
        raise GpsecError(f"{path}: expected {what}, found no file")
    try:
        table = pd.read_parquet(path)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise GpsecError(f"{path}: expected {what} in Parquet, found another file ({shown(error)})") from None
    for name in columns:
        if name not in table:
            raise GpsecError(f"{path}: expected {what} with the columns {', '.join(columns)}, found no '{name}'")
    texts: Mapping[str, type] = {"vehicle": str, "attack": str}
    return table[columns].astype({name: kind for name, kind in texts.items() if name in columns})


def _check(path: Path, given: pd.DataFrame) -> None:
    if given[SCORE].dtype.kind not in "fiu":
        raise GpsecError(f"{path}: column '{SCORE}': expected numbers, found {given[SCORE].dtype}")
    score = given[SCORE].to_numpy(np.float64)
    wrong = score[(score < 0.0) | np.isinf(score)]
    if len(wrong):
        raise GpsecError(
            f"{path}: column '{SCORE}': expected finite numbers of at least 0, the higher the more anomalous, "
            f"found {wrong[0]:g}; any rising function of a score will do, such as its exponential"
        )
    twice = given.duplicated(list(SCORED_ROW))
    if twice.any():
        row = given[twice].iloc[0]
        raise GpsecError(
            f"{path}: two scores of vehicle '{shown(row['vehicle'])}', '{row['attack']}', step {row['step']}"
        )
