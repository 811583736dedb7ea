"""Pictures of one vehicle: residual, statistics, and its path with and without mitigation."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pyarrow import parquet

from gpsec.core.errors import GpsecError
from gpsec.hdmap.map import load_map
from gpsec.outcomes.tables import STEP_LOG, read_table
from gpsec.paper.design import (
    NONE,
    PAPER,
)
from gpsec.paper.plotting import LINE_COLOURS, canvas
from gpsec.paper.pool import named_plainly
from gpsec.scenario import Scenario
from gpsec.scenario.choices import BOUNDS
from gpsec.scenario.traffic import sumo_options
from gpsec.types.constants import MANIFEST

# Shown before and after the attack.
_MARGIN_S = 8.0
# Lanes that are drawn around a path.
_AROUND_M = 30.0


def statistics(run: Path, attack: str, path: Path) -> None:
    """Draw residual, statistics and thresholds of a typical vehicle, with the time under attack."""
    log = _typical(run, attack)
    thresholds = _thresholds(run)
    columns = [str(name) for name in log.columns if str(name).endswith("_statistic")]
    names = [name for name in (column.removesuffix("_statistic") for column in columns) if name not in BOUNDS]
    with canvas(path, 1 + len(names), 1, size=(7.5, 1.5)) as axes:
        time_s = log["time_s"].to_numpy()
        axes[0, 0].plot(time_s, log["residual_m"], color="0.2", linewidth=0.9)
        axes[0, 0].set_ylabel("residual (m)")
        for row, name in enumerate(names, start=1):
            axes[row, 0].plot(time_s, log[f"{name}_statistic"], color=LINE_COLOURS(name), linewidth=1.0, label=name)
            axes[row, 0].axhline(thresholds[name], color="0.2", linestyle="--", linewidth=0.8)
            axes[row, 0].set_yscale("symlog", linthresh=max(thresholds[name], 1e-3))
            axes[row, 0].set_ylim(bottom=0.0)
        for one in axes[:, 0]:
            one.axvspan(*_window(log), color="#D55E00", alpha=0.12, linewidth=0)
        axes[-1, 0].set_xlabel("time (s); shaded: under attack; dashed: threshold")


def trajectory(run: Path, attack: str, path: Path) -> None:
    """Draw the true path of a typical vehicle on its lanes, and its estimated paths under some defences."""
    log = _typical(run, attack)
    log = log[log["attacked"]]
    defences = ["+".join(NONE), *(f"{PAPER[0]}+{name}" for name in _responses(log))]
    with canvas(path, 1, 2, size=(4.6, 4.2)) as axes:
        whole_way, part = axes[0]
        _lanes(run, log, whole_way)
        for name in defences:
            whole_way.plot(log[f"{name}_x_m"], log[f"{name}_y_m"], color=LINE_COLOURS(name), label=name, linewidth=1.2)
        whole_way.plot(log["x_m"], log["y_m"], color="black", linestyle=":", label="truth", linewidth=1.4)
        whole_way.set_aspect("equal", "datalim")
        whole_way.set_xlabel("east (m)")
        whole_way.set_ylabel("north (m)")
        since_s = log["time_s"] - log["time_s"].iloc[0]
        for name in defences:
            error = np.hypot(log[f"{name}_x_m"] - log["x_m"], log[f"{name}_y_m"] - log["y_m"])
            part.plot(since_s, error, color=LINE_COLOURS(name), label=name, linewidth=1.2)
        part.set_xlabel("time since the attack began (s)")
        part.set_ylabel("distance from the truth (m)")


def _typical(run: Path, attack: str) -> pd.DataFrame:
    """Return the steps of the vehicle with the median error under the paper's defence.

    Before the attack, a vehicle is the same as under no attack, where the log has it.
    """
    events = named_plainly(read_table(run, "events"))
    mine = events[(events["attack"] == attack) & (events["defence"] == "+".join(PAPER)) & ~events["cut_short"]]
    if mine.empty:
        raise GpsecError(
            f"{run}: expected vehicles that were attacked from beginning to end under '{attack}', found none"
        )
    chosen = mine.sort_values("rmse_xy_m").iloc[len(mine) // 2]
    only = [("vehicle_id", "==", chosen["vehicle_id"])]
    log: pd.DataFrame = named_plainly(parquet.read_table(run / STEP_LOG, filters=only).to_pandas())
    after = (log["plan"] == attack) & (log["time_s"] <= chosen["end_s"] + _MARGIN_S)
    start_s = log.loc[log["plan"] == attack, "time_s"].min()
    before = (log["plan"] == "none") & (log["time_s"] < start_s) & (log["time_s"] >= start_s - _MARGIN_S)
    steps: pd.DataFrame = log[before | after].sort_values("time_s")
    return steps


def _window(log: pd.DataFrame) -> tuple[float, float]:
    attacked = log.loc[log["attacked"], "time_s"]
    return float(attacked.min()), float(attacked.max())


def _thresholds(run: Path) -> dict[str, float]:
    table = named_plainly(read_table(run, "detection"))
    return {str(name): float(value) for name, value in zip(table["detector"], table["threshold"], strict=True)}


def _responses(log: pd.DataFrame) -> list[str]:
    mark = f"{PAPER[0]}+"
    columns = [str(name) for name in log.columns if str(name).startswith(mark) and str(name).endswith("_x_m")]
    return [name.removeprefix(mark).removesuffix("_x_m") for name in columns]


def _lanes(run: Path, log: pd.DataFrame, axes: Any) -> None:
    """Draw the borders of the lanes around a path."""
    manifest = json.loads((run / MANIFEST).read_text(encoding="utf-8"))
    hd_map = load_map(sumo_options(Scenario.model_validate(manifest["configuration"])).net_file, ())
    low, high = (log[["x_m", "y_m"]].agg(side).to_numpy() for side in ("min", "max"))
    for number, width_m in enumerate(hd_map.sides.width_m):
        line = hd_map.centre_line(number)
        if (line.max(axis=0) < low - _AROUND_M).any() or (line.min(axis=0) > high + _AROUND_M).any():
            continue
        along = np.gradient(line, axis=0)
        left = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, np.newaxis]
        for side in (-0.5, 0.5):
            axes.plot(*(line + side * width_m * left).T, color="0.75", linewidth=0.7, zorder=1)
