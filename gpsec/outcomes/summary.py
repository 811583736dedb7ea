"""Prints the tables of a finished run in the paper's form, its rows beside ours; whole from 80 columns on."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, repeat
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console, Group
from rich.table import Table

from gpsec.outcomes.costs_summary import costs_summary
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.paper import PublishedScores, detection_like, localization_like
from gpsec.outcomes.printing import (
    HEADING_WIDTH,
    NARROWEST_LABEL,
    WIDEST_LABEL,
    Manifest,
    Row,
    add_label,
    caption_line,
    counted_things,
    filled_lines,
    fits_console,
    labelled_table,
    narrow_heading,
    number_cell,
    run_name,
    title_line,
    triple_of,
    with_interval,
    without_interval,
)
from gpsec.outcomes.reading import read_manifests, read_pooled
from gpsec.outcomes.state import OUTCOMES
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import detector_at

# Bounds of every table; there is nothing in their precision and recall that is not known beforehand.
_BOUNDS = {"told", "never"}

# What can be printed: the names of the tables, and what the run cost.
PARTS = ("detection", "localization", "safety", "costs")


def print_summary(out: Path, console: Console, parts: Sequence[str] = PARTS) -> None:
    """Print `PARTS`, or some of them, of the run in the folder `out`.

    Table I's form (attack × detector), Tables II–IV's (attack × defence), what the errors would have meant, and what
    SUMO and the security layer cost.
    """
    runs = read_manifests(out)
    for part in parts:
        if part == "costs":
            console.print(costs_summary(runs, console))
            continue
        for (scenario, profile), rows in _groups(read_pooled(out, part), ["scenario", "profile"]):
            for shape in _PRINTED[part](scenario, profile, rows, runs, console):
                console.print(shape, markup=False, highlight=False)


def _of_detection(
    scenario: str, profile: str, rows: pd.DataFrame, runs: Sequence[Manifest], console: Console
) -> Iterator[Group | str]:
    if (rows["n_events"] > 0).any():
        yield _detection(scenario, profile, rows, _attacks(runs, scenario), console)
    yield _false_alarms(scenario, profile, rows, console)
    if (rows["n_line_events"] > 0).any():
        yield _before_the_line(scenario, profile, rows, console)


def _of_localization(
    scenario: str, profile: str, rows: pd.DataFrame, runs: Sequence[Manifest], console: Console
) -> Iterator[Group | str]:
    if (rows["n_vehicles"] > 0).any():
        yield _localization(scenario, profile, rows, console)


def _of_safety(
    scenario: str, profile: str, rows: pd.DataFrame, runs: Sequence[Manifest], console: Console
) -> Iterator[Group | str]:
    if (rows["n_vehicles"] > 0).any():
        yield _safety(scenario, profile, rows, console)
        yield _without_gnss(scenario, profile, rows, console)


_PRINTED = {"detection": _of_detection, "localization": _of_localization, "safety": _of_safety}


def _groups(table: pd.DataFrame, by: list[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    """Return the groups of a table in the order of their first rows."""
    return ((key, rows) for key, rows in table.groupby(by, sort=False))


def _attacks(runs: Sequence[Manifest], scenario: str) -> dict[str, str] | None:
    """Return the attack of each plan by the plan's name; None where the manifest is a former one and does not tell."""
    for run in runs:
        if scenario in (run_name(run), base_name(run_name(run))) and "plans" in run:
            return {plan["name"]: plan["attack"] for plan in run["plans"]}
    return None


def _detection(
    scenario: str, profile: str, rows: pd.DataFrame, attacks: Mapping[str, str] | None, console: Console
) -> Group:
    paper = {
        (name, detector): detection_like(name if attacks is None else attacks.get(name, ""), detector_at(detector))
        for name, detector in zip(rows["attack"], rows["detector"], strict=True)
    }
    events = rows[(rows["n_events"] > 0) & ~rows["detector"].isin(_BOUNDS)]
    caption = "mean and interval over resampled vehicles; told and never are in detection.csv"
    table = _detection_table(events, paper, wide=True)
    if not fits_console(table, console):
        caption = "intervals, told and never are in detection.csv"
        table = _detection_table(events, paper, wide=False)
    if any(paper.values()):
        caption += "; the paper's figures are for its own data and parameters"
    return Group(
        title_line(f"Detection (form of Table I): {scenario}, profile {profile}"), table, caption_line(caption)
    )


def _detection_table(
    rows: pd.DataFrame, paper: Mapping[tuple[str, str], PublishedScores | None], *, wide: bool
) -> Table:
    """Return ours with intervals and the paper's in a column of their own, or else below ours and without intervals."""
    table = labelled_table("attack", HEADING_WIDTH if wide else WIDEST_LABEL - 2)
    add_label(table, "detector", HEADING_WIDTH + 2)
    for heading in ("precision", "recall", "F1", "delay (s)", *(["paper P/R/F1 delay"] if wide else [])):
        table.add_column(heading, justify="right", no_wrap=True)
    for (attack,), group in _groups(rows, ["attack"]):
        lines = []
        for row in group.to_dict("records"):
            theirs = paper[attack, row["detector"]]
            if wide:
                lines.append([_short(row["detector"]), *_figures(row, with_interval), _abreast(theirs)])
                continue
            lines.append([_short(row["detector"]), *_figures(row, without_interval)])
            if theirs:
                lines.append(["  paper", *_published(theirs)])
        events = counted_things(group["n_events"].iloc[0], "event")
        labels = [attack, events] if len(lines) > 1 else [f"{attack}\n{events}"]
        for label, line in zip(chain(labels, repeat("")), lines, strict=False):
            table.add_row(label, *line)
        table.add_section()
    return table


def _short(point: str) -> str:
    """Return the name of a detector, of its further rates only the rate: they stand below it."""
    _, at, rate = point.partition("@")
    return f"  @{rate}" if at else point


def _figures(row: Row, text: Callable[[Row, str], str]) -> list[str]:
    return [text(row, name) for name in ("precision", "recall", "f1", "delay_mean_s")]


def _published(paper: PublishedScores) -> list[str]:
    return [f"{paper.precision:.2f}", f"{paper.recall:.2f}", f"{paper.f1:.2f}", f"{paper.delay_s:.1f}"]


def _abreast(paper: PublishedScores | None) -> str:
    if paper is None:
        return ""
    *shares, delay = _published(paper)
    return f"{'/'.join(shares)} {delay}"


def _false_alarms(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> str:
    first = rows.drop_duplicates("detector")
    name = "false_alarms_per_vehicle_hour"
    rates = [f"{row['detector']} {number_cell(row[name], '.2f')}" for row in first.to_dict("records")]
    hours = f"{first['vehicle_hours'].max():.2f} vehicle-hours without an attack"
    return f"False alarms per vehicle-hour: {scenario}, profile {profile} ({hours})\n{filled_lines(rates, console)}\n"


def _before_the_line(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> str:
    """Say of each attack how many were seen before the undefended vehicle would have touched a line."""
    said = [f"Seen before the undefended vehicle would have touched a line: {scenario}, profile {profile}"]
    for (attack,), group in _groups(rows[~rows["detector"].isin(_BOUNDS)], ["attack"]):
        events = int(group["n_line_events"].iloc[0])
        if events:
            shares = [f"{row['detector']} {row['seen_before_line_share']:.0%}" for row in group.to_dict("records")]
            said.append(filled_lines([f"{attack} ({events}):", *shares], console))
    return "\n".join(said) + "\n"


def _without_gnss(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> str:
    first = rows.drop_duplicates("defence")
    name = "isolated_minutes_per_vehicle_hour"
    said = [f"{row['defence']} {number_cell(row[name], '.2f')}" for row in first.to_dict("records")]
    heading = f"Minutes without GNSS per vehicle-hour without an attack: {scenario}, profile {profile}"
    return "\n".join([*rows["note"].dropna().unique(), heading, filled_lines(said, console), ""])


def _localization(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> Group:
    paper = localization_like(scenario, profile)
    extra: dict[str, dict[str, str]] = {}
    caption = "during the attack, none: over the whole settled life; never+none is without mitigation"
    if paper:
        figures = {UNDEFENDED: paper.undefended_m, "lstm+ukf": paper.mitigated_m, "lstm_glr+ukf": paper.mitigated_m}
        extra[f"paper, {paper.table}"] = {name: triple_of(values) for name, values in figures.items()}
        caption += "; the paper's figures are for its own data and parameters, and it does not say which attack it is"
    return _matrix(
        f"RMSE x/y/xy in m (form of Tables II–IV): {scenario}, profile {profile}",
        rows[rows["n_vehicles"] > 0],
        lambda row: triple_of([row["rmse_x_m"], row["rmse_y_m"], row["rmse_xy_m"]]),
        extra,
        caption,
        console,
    )


def _safety(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> Group:
    where = f"{scenario}, profile {profile}"
    return _matrix(
        f"Vehicles that would have touched a line/left their lane/gone the wrong way/left the road: {where}",
        rows[rows["n_vehicles"] > 0],
        lambda row: "/".join(number_cell(row[outcome], ".0f") for outcome in OUTCOMES),
        {},
        "attack (vehicles); a vehicle that steered by its estimate, measured from the centre line of its lane",
        console,
        count="n_vehicles",
    )


def _matrix(
    title: str,
    rows: pd.DataFrame,
    cell: Callable[[Row], str],
    extra: dict[str, dict[str, str]],
    caption: str,
    console: Console,
    count: str = "",
) -> Group:
    """Return tables of attack × defence, undefended first, as many as it takes to fit the console's width."""
    defences = sorted(rows["defence"].unique(), key=lambda name: name != UNDEFENDED)
    lines: dict[str, dict[str, str]] = {}
    for row in rows.to_dict("records"):
        label = f"{row['attack']} ({row[count]})" if count else row["attack"]
        lines.setdefault(label, {})[row["defence"]] = cell(row)
    lines |= extra
    widest = max((len(text) for cells in lines.values() for text in cells.values()), default=0)
    labels = min(max((len(label) for label in lines), default=0), WIDEST_LABEL)
    labels = max(labels, NARROWEST_LABEL)
    # A column takes its padding and the gap before it; the labels' takes only its padding.
    fitting = max(1, (console.width - labels - 1) // (max(widest, HEADING_WIDTH) + 2))
    tables = []
    for start in range(0, len(defences), fitting):
        abreast = defences[start : start + fitting]
        table = labelled_table("attack", labels)
        for name in abreast:
            table.add_column(narrow_heading(name), justify="right", no_wrap=True)
        for label, cells in lines.items():
            table.add_row(label, *(cells.get(name, "") for name in abreast))
        tables.append(table)
    return Group(title_line(title), *tables, caption_line(caption))
