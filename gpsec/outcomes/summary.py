"""Prints the tables of a finished run in the paper's form, its rows beside ours; 120 columns wide."""

import json
import re
from collections.abc import Callable, Hashable, Iterable, Sequence
from itertools import chain, repeat
from pathlib import Path
from typing import Any

import pandas as pd
from rich import box
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from gpsec.outcomes.paper import TABLE_I, localization_like
from gpsec.outcomes.state import OUTCOMES
from gpsec.outcomes.tables import MANIFEST, read_table

UNDEFENDED = "never+none"
# Bounds of every table; there is nothing in their precision and recall that is not known beforehand.
_BOUNDS = {"oracle", "never"}
_WIDTH = 120
_HEADING_WIDTH = 14
_EMPTY = "–"
_FORM: dict[str, Any] = {
    "box": box.SIMPLE_HEAD,
    "padding": (0, 1, 0, 0),
    "caption_justify": "left",
    "show_edge": False,
}

Row = dict[Hashable, Any]


def print_summary(out: Path, console: Console) -> None:
    """Print what is in the folder `out` that `gpsec run` has written.

    Table I's form (attack × detector), Tables II–IV's (attack × defence), what the errors would have meant, and what
    SUMO and the security layer cost.
    """
    for (scenario, profile), rows in _groups(read_table(out, "detection"), ["scenario", "profile"]):
        if (rows["n_events"] > 0).any():
            console.print(_detection(scenario, profile, rows))
        console.print(_false_alarms(scenario, profile, rows), markup=False, highlight=False)
    for (scenario, profile), rows in _groups(read_table(out, "localization"), ["scenario", "profile"]):
        if (rows["n_vehicles"] > 0).any():
            console.print(_localization(scenario, profile, rows))
    for (scenario,), rows in _groups(read_table(out, "safety"), ["scenario"]):
        console.print(_safety(scenario, rows))
    console.print(_costs(json.loads((out / MANIFEST).read_text("utf-8"))))


def _groups(table: pd.DataFrame, by: list[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    """Return the groups of a table in the order of their first rows."""
    return ((key, rows) for key, rows in table.groupby(by, sort=False))


def _detection(scenario: str, profile: str, rows: pd.DataFrame) -> Group:
    table = _table()
    table.add_column("detector", no_wrap=True)
    for heading in ("precision", "recall", "F1", "delay (s)", "paper P/R/F1 delay"):
        table.add_column(heading, justify="right", no_wrap=True)
    for (attack,), group in _groups(rows[(rows["n_events"] > 0) & ~rows["detector"].isin(_BOUNDS)], ["attack"]):
        events = f"{group['n_events'].iloc[0]} events"
        labels = [attack, events] if len(group) > 1 else [f"{attack}\n{events}"]
        for label, row in zip(chain(labels, repeat("")), group.to_dict("records"), strict=False):
            table.add_row(label, *_detection_cells(row))
        table.add_section()
    table.caption = "mean and interval over resampled vehicles; oracle and never are in detection.csv"
    return Group(_title(f"Detection (form of Table I): {scenario}, profile {profile}"), table)


def _detection_cells(row: Row) -> list[str]:
    paper = TABLE_I.get((row["attack"], row["detector"]))
    beside = f"{paper.precision:.2f}/{paper.recall:.2f}/{paper.f1:.2f} {paper.delay_s:.1f}" if paper else ""
    figures = [_with_interval(row, name) for name in ("precision", "recall", "f1", "delay_mean_s")]
    return [row["detector"], *figures, beside]


def _false_alarms(scenario: str, profile: str, rows: pd.DataFrame) -> str:
    first = rows.drop_duplicates("detector")
    name = "false_alarms_per_vehicle_hour"
    rates = "  ".join(f"{row['detector']} {_number(row[name], '.2f')}" for row in first.to_dict("records"))
    hours = f"{first['vehicle_hours'].max():.2f} vehicle-hours without an attack"
    return f"False alarms per vehicle-hour: {scenario}, profile {profile} ({hours})\n  {rates}\n"


def _localization(scenario: str, profile: str, rows: pd.DataFrame) -> Group:
    paper = localization_like(scenario, profile)
    extra: dict[str, dict[str, str]] = {}
    if paper:
        figures = {UNDEFENDED: paper.undefended_m, "lstm+ukf": paper.mitigated_m}
        extra[f"paper, {paper.table}"] = {name: _triple(values) for name, values in figures.items()}
    return _matrix(
        f"RMSE x/y/xy in m (form of Tables II–IV): {scenario}, profile {profile}",
        rows[rows["n_vehicles"] > 0],
        lambda row: _triple([row["rmse_x_m"], row["rmse_y_m"], row["rmse_xy_m"]]),
        extra,
        "during the attack, none: over the whole settled life; never+none is without mitigation",
    )


def _safety(scenario: str, rows: pd.DataFrame) -> Group:
    return _matrix(
        f"Vehicles that would have touched a line/left their lane/gone the wrong way/left the road: {scenario}",
        rows,
        lambda row: "/".join(str(row[outcome]) for outcome in OUTCOMES),
        {},
        "attack (vehicles); a vehicle that steered by its estimate, measured from the centre line of its lane",
        count="n_vehicles",
    )


def _matrix(
    title: str,
    rows: pd.DataFrame,
    cell: Callable[[Row], str],
    extra: dict[str, dict[str, str]],
    caption: str,
    count: str = "",
) -> Group:
    """Return tables of attack × defence, undefended first, as many as it takes to fit the width."""
    defences = sorted(rows["defence"].unique(), key=lambda name: name != UNDEFENDED)
    lines: dict[str, dict[str, str]] = {}
    for row in rows.to_dict("records"):
        label = f"{row['attack']} ({row[count]})" if count else row["attack"]
        lines.setdefault(label, {})[row["defence"]] = cell(row)
    lines |= extra
    widest = max((len(text) for cells in lines.values() for text in cells.values()), default=0)
    labels = max((len(label) for label in lines), default=0)
    fitting = max(1, (_WIDTH - labels) // (max(widest, _HEADING_WIDTH) + 2))
    tables = []
    for start in range(0, len(defences), fitting):
        abreast = defences[start : start + fitting]
        table = _table()
        for name in abreast:
            table.add_column(_narrow(name), justify="right", no_wrap=True)
        for label, cells in lines.items():
            table.add_row(label, *(cells.get(name, "") for name in abreast))
        tables.append(table)
    return Group(_title(title), *tables, Text(f"{caption}\n", style="italic"))


_COSTS = (
    "SUMO\n(s)",
    "reading\n(s)",
    "security\n(s)",
    "vehicle-\nsteps",
    "peak\nvehicles",
    "SUMO\n(µs)",
    "security\n(µs)",
)


def _costs(manifest: dict[str, Any]) -> Group:
    table = Table(**_FORM)
    table.add_column("scenario", overflow="fold")
    for name in _COSTS:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("slowest stages\n(s)", overflow="fold")
    for run in manifest.get("scenarios", [manifest]):
        stages = run.get("stages_s", {})
        security, steps = sum(stages.values()), run.get("vehicle_steps", 0)
        slowest = sorted(stages.items(), key=lambda item: -item[1])[:3]
        named = run.get("name", run.get("scenario", ""))
        table.add_row(
            named if isinstance(named, str) else str(named.get("name", "")),
            _number(run.get("sumo_s"), ".1f"),
            _number(run.get("read_s"), ".1f"),
            f"{security:.1f}",
            f"{steps:,}",
            f"{run.get('peak_vehicles', 0):,}",
            *(
                _number(seconds / steps * 1e6 if steps else None, ".1f")
                for seconds in (run.get("sumo_s", 0.0), security)
            ),
            ", ".join(f"{name} {seconds:.1f}" for name, seconds in slowest),
        )
    table.caption = "µs: for every vehicle and step; security: all plans and defences together"
    return Group(_title("What it cost"), table)


def _title(text: str) -> Text:
    return Text(f"\n{text}", style="bold")


def _table() -> Table:
    table = Table(**_FORM)
    table.add_column("attack", overflow="fold")
    return table


def _narrow(defence: str) -> str:
    """Return a heading of several lines, broken where a name is joined."""
    lines = [""]
    for word in re.findall(r"\+?[^_+]+_?", defence):
        if word.startswith("+") or len(lines[-1]) + len(word) > _HEADING_WIDTH:
            lines.append("")
        lines[-1] += word
    return "\n".join(line for line in lines if line)


def _with_interval(row: Row, name: str) -> str:
    if pd.isna(row[name]):
        return _EMPTY
    digits = 2 if row[f"{name}_hi"] < 9.995 else 1
    middle, low, high = (f"{row[key]:.{digits}f}" for key in (name, f"{name}_lo", f"{name}_hi"))
    return f"{middle} {low}–{high}"


def _triple(values: Sequence[float]) -> str:
    """Return three figures of four characters each, so that six defences fit the width."""
    return "/".join(_four(value) for value in values)


def _four(value: float) -> str:
    if pd.isna(value):
        return _EMPTY
    if value < 0.0995:
        return f"{value:.3f}".removeprefix("0")
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def _number(value: float | None, form: str) -> str:
    return _EMPTY if value is None or pd.isna(value) else format(value, form)
