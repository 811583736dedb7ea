"""The page of a sweep: small multiples, a row for each measure and a panel for each scenario, over what varies."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.version import __version__
from gpsec.report.figure_data import Figure, Series, colours
from gpsec.report.page import render, write_page
from gpsec.sweeps.folder import read_folder
from gpsec.sweeps.results import Sweep
from gpsec.sweeps.state import state_of
from gpsec.types.constants import REPORT, UNDEFENDED

# Enough for a picture; `Sweep.over_seeds` has as many as one asks for.
_REPLICATES = 200


@dataclass(frozen=True)
class Measure:
    """What a row of panels shows.

    Attributes:
        table, column: where it is.
        title: of the row; unit: of the axis.
        factor: by which it is drawn.
        by: what has a line each.
    """

    table: str
    column: str
    title: str
    unit: str
    factor: float
    by: str


_MEASURES = (
    Measure("safety", "out_of_lane_share", "Vehicles that would leave their lane", "per cent", 100.0, "defence"),
    Measure("detection", "detected_share", "Attacks that are seen", "per cent", 100.0, "detector"),
    Measure("detection", "delay_mean_s", "Time to detect", "s", 1.0, "detector"),
    Measure("detection", "false_alarms_per_vehicle_hour", "False alarms", "per vehicle-hour", 1.0, "detector"),
    Measure(
        "safety", "isolated_minutes_per_vehicle_hour", "Time without GNSS", "minutes per vehicle-hour", 1.0, "defence"
    ),
)


def write_sweep(folder: Path, tell: Callable[[int, int], None] | None = None) -> Path | None:
    """Write the page of the sweep in a folder into it; return where it is, None where nothing has been gathered.

    `tell` is told how far the figures are.

    Raises:
        GpsecError: it is no sweep, or a part of it cannot be read.
        OSError: the disk refuses.
    """
    sweep = Sweep(read_folder(folder))
    tables = sweep.over_seeds(_REPLICATES, tell=tell)
    if not tables:
        return None
    rows = [(measure.title, list(_panels(tables[measure.table], measure, sweep))) for measure in _MEASURES]
    rows = [(title, panels) for title, panels in rows if panels]
    figures = {panel.key: panel for _, panels in rows for panel in panels}
    safety = tables["safety"]
    groups, attacks = list(dict.fromkeys(safety["entry"])), list(dict.fromkeys(safety["attack"]))
    page = render(
        "sweep.html",
        {"figures": {key: one.plain() for key, one in figures.items()}, "groups": groups, "attacks": attacks},
        title=folder.resolve().name,
        rows=rows,
        groups=groups,
        attacks=[name for name in attacks if name != "none"] or attacks,
        said=next(state_of(sweep.folder).lines()).partition(": ")[2],
        version=__version__,
    )
    write_page(folder / REPORT, page)
    return folder / REPORT


def axis_of(table: pd.DataFrame, kinds: Mapping[str, str]) -> str:
    """Return the parameter that is drawn along: the number with most values, else what has most; empty for none."""
    counts = {key: count for key in kinds if (count := len(table[key].dropna().unique())) > 1}
    return max(counts, key=lambda key: (kinds[key] == "number", counts[key]), default="")


def _panels(table: pd.DataFrame, measure: Measure, sweep: Sweep) -> Iterator[Figure]:
    """Yield a panel for each scenario that has the measure."""
    kinds = sweep.folder.parameters
    paint = colours(table[measure.by].unique(), UNDEFENDED)
    for number, (scenario, mine) in enumerate(table.groupby("scenario", sort=False)):
        series = []
        for entry, rows in mine.groupby("entry", sort=False):
            axis = axis_of(rows, kinds)
            others = [key for key in kinds if key != axis and len(rows[key].unique()) > 1]
            rest = ["profile", "attack", *others, measure.by]
            for names, line in rows.groupby(rest, sort=False, dropna=False):
                known = line[line[measure.column].notna()]
                if len(known) and not (axis and known[axis].isna().all()):
                    where = {"group": str(entry), **_where(dict(zip(rest[:-1], names, strict=False)))}
                    series.append(_line(known, measure, axis, where, paint))
        if series:
            labels = {axis_of(rows, kinds) for _, rows in mine.groupby("entry", sort=False)}
            yield Figure(
                f"{measure.column}-{number}",
                str(scenario),
                " or ".join(sorted(label for label in labels if label)),
                measure.unit,
                series,
                "There is nothing to draw for this choice.",
                layout={"yaxis": {"rangemode": "tozero"}},
            )


def _where(names: Mapping[Any, Any]) -> dict[str, str]:
    return {
        str(key): "–" if pd.isna(value) else f"{value:g}" if isinstance(value, float) else str(value)
        for key, value in names.items()
    }


def _line(
    rows: pd.DataFrame, measure: Measure, axis: str, where: Mapping[str, str], paint: Mapping[str, int]
) -> Series:
    rows = rows.sort_values(axis) if axis else rows
    number = bool(axis) and pd.api.types.is_numeric_dtype(rows[axis])
    places = rows[axis].tolist() if number else rows[axis].astype(str).tolist() if axis else rows["scenario"].tolist()
    name = str(rows[measure.by].iloc[0])
    column = rows[measure.column] * measure.factor
    low, high = (rows[f"{measure.column}{end}"] * measure.factor for end in ("_lo", "_hi"))
    return Series(
        name,
        "trail" if number else "points",
        places,
        column.tolist(),
        low=low.tolist(),
        high=high.tolist(),
        colour=paint[name],
        where=where,
    )
