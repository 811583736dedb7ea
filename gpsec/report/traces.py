"""The figures of single vehicles: lane offsets, residual, statistics, path."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
import pandas as pd

from gpsec.outcomes.samples import AFTER_S, BEFORE_S
from gpsec.report.figure_data import Figure, Series, colours
from gpsec.report.figures import defences_of, detectors_of
from gpsec.report.stories import Story
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED

# A sample is drawn until the next one: cameras and detectors have none in every short step.
_HELD_S = 0.2
# Points of a line; more of them cannot be seen, and weigh.
_MOST_POINTS = 400

NOT_KEPT = (
    "The run has kept no steps of a vehicle here: nobody was attacked, or it is of an older version."
    " `gpsec report RUN --again` runs SUMO once more on the scenario that the run names, and draws them;"
    " `gpsec trace RUN VEHICLE` does it for any vehicle."
)


def rows_of(story: Story, steps: pd.DataFrame) -> pd.DataFrame:
    """Return the steps of a story: without the attack before it began, under the attack from then on."""
    mine = steps[steps["vehicle_id"] == story.vehicle_id]
    before = (mine["plan"] == "none") & ((mine["time_s"] < story.start_s - 1e-6) | (story.attack == "none"))
    rows = mine[before | ((mine["plan"] == story.attack) & (story.attack != "none"))]
    shown = (rows["time_s"] >= story.start_s - BEFORE_S) & (rows["time_s"] <= story.end_s + AFTER_S)
    rows = _held(rows[shown].sort_values("time_s"))
    return rows.iloc[:: max(1, -(-len(rows) // _MOST_POINTS))]


def _held(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows with the last value of camera, residual and statistics carried on, for at most `_HELD_S`."""
    step_s = rows["time_s"].diff().min()
    limit = ceil(_HELD_S / step_s - 1e-6) - 1 if step_s > 0.0 else 0
    if limit < 1:
        return rows
    sampled = [name for name in rows if name in ("camera_offset_m", "residual_m") or str(name).endswith("_statistic")]
    return rows.assign(**{str(name): rows[name].ffill(limit=limit) for name in sampled})


def trace_figures(
    run: Results, stories: Sequence[Story], steps: Mapping[str, pd.DataFrame | None]
) -> dict[str, Figure]:
    """Return the four figures of `stories`; `steps` holds those of each scenario, None where they are not known."""
    parts: dict[str, list[Series]] = {"offsets": [], "residual": [], "statistics": [], "path": []}
    detectors, defences = detectors_of(run), defences_of(run)
    for story in stories:
        logged = steps.get(story.scenario)
        rows = None if logged is None else rows_of(story, logged)
        if rows is None or rows.empty:
            continue
        where = {"group": story.group, "vehicle": story.label}
        span = []
        if story.attack != "none":
            window = [story.start_s, story.end_s]
            span = [Series("under attack", "span", window, [0.0, 0.0], colour=4, where=where)]
        time = rows["time_s"].to_numpy()
        parts["offsets"] += [*span, *_offsets(rows, time, where)]
        parts["residual"] += [
            *span,
            Series("residual", "line", time, rows["residual_m"].to_numpy(), colour=4, where=where),
        ]
        parts["statistics"] += [*span, *_statistics(run, story, rows, time, where, detectors)]
        parts["path"] += _path(rows, where, defences)
    seconds = "simulated time (s)"
    figures = [
        Figure(
            "trace_offsets",
            "Lane offset by camera and by map",
            seconds,
            "left of the lane's centre (m)",
            parts["offsets"],
            NOT_KEPT,
            "What the camera sees, what the map gives for the GNSS position, and the truth. Gaps: no fix, no marking.",
        ),
        Figure("trace_residual", "Residual", seconds, "camera − map (m)", parts["residual"], NOT_KEPT),
        Figure(
            "trace_statistics",
            "Statistics of the detectors",
            seconds,
            "statistic / threshold",
            parts["statistics"],
            NOT_KEPT,
            "Each over its own threshold: above 1 it is an alarm. Values under 0.01 are drawn there.",
            {"yaxis": {"type": "log", "dtick": 1}},
        ),
        Figure(
            "trace_path",
            "True and estimated path",
            "east (m)",
            "north (m)",
            parts["path"],
            NOT_KEPT,
            "From ten seconds before the attack to twenty after it; metres from where it began. Click names to hide"
            " them.",
            {"yaxis": {"scaleanchor": "x"}},
            tall=True,
        ),
    ]
    return {figure.key: figure for figure in figures}


def _offsets(rows: pd.DataFrame, time: Any, where: Mapping[str, str]) -> list[Series]:
    camera, residual = rows["camera_offset_m"].to_numpy(), rows["residual_m"].to_numpy()
    return [
        Series("truth", "line", time, rows["lane_offset_m"].to_numpy(), where=where),
        Series("camera", "line", time, camera, colour=2, where=where),
        Series("map, from GNSS", "line", time, camera - residual, colour=4, where=where),
    ]


def _statistics(
    run: Results, story: Story, rows: pd.DataFrame, time: Any, where: Mapping[str, str], detectors: Sequence[str]
) -> list[Series]:
    table = run.detection
    mine = table[(table["scenario"] == story.scenario) & (table["profile"] == story.profile)]
    threshold = mine.drop_duplicates("detector").set_index("detector")["threshold"]
    colour = colours(detectors)
    made = [Series("threshold", "line", [time[0], time[-1]], [1.0, 1.0], where=where)]
    for name in detectors:
        if f"{name}_statistic" in rows and threshold.get(name, 0.0) > 0.0:
            ratio = rows[f"{name}_statistic"].to_numpy() / threshold[name]
            made.append(Series(name, "line", time, np.maximum(ratio, 0.01), colour=colour[name], where=where))
    return made


def _path(rows: pd.DataFrame, where: Mapping[str, str], defences: Sequence[str]) -> list[Series]:
    attacked = rows[rows["attacked"]]
    first = (attacked if len(attacked) else rows).iloc[0]
    colour = colours(defences, UNDEFENDED)

    def line(name: str, prefix: str, number: int, kind: str = "line") -> Series:
        x, y = rows[f"{prefix}x_m"] - first["x_m"], rows[f"{prefix}y_m"] - first["y_m"]
        return Series(name, kind, x.to_numpy(), y.to_numpy(), colour=number, where=where, mark="x-thin-open")

    made = [line("truth", "", -1), line("GNSS fix", "fix_", 4, "points")]
    for name in defences:
        if f"{name}_x_m" in rows:
            made.append(line(name, f"{name}_", colour[name] if name != UNDEFENDED else 5))
    return made
