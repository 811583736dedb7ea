"""Prints the tables of a finished run in the paper's form, its rows beside ours; whole from 80 columns on."""

import re
import textwrap
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, repeat
from pathlib import Path
from typing import Any

import pandas as pd
from rich import box
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from gpsec.outcomes.naming import base_name
from gpsec.outcomes.paper import PublishedScores, detection_like, localization_like
from gpsec.outcomes.reading import read_manifests, read_pooled
from gpsec.outcomes.state import OUTCOMES
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import detector_at

# Bounds of every table; there is nothing in their precision and recall that is not known beforehand.
_BOUNDS = {"told", "never"}
_HEADING_WIDTH = 14
# Names are folded beyond the widest, and never squeezed below the narrowest.
_NARROWEST_LABEL = 10
_WIDEST_LABEL = 24
_STAGES_WIDTH = 40
# Wider than any table, to measure what one needs.
_UNLIMITED = 10_000
# Compiling that is not worth a word.
_SHORT_S = 1.0
_EMPTY = "–"
_FORM: dict[str, Any] = {
    "box": box.SIMPLE_HEAD,
    "padding": (0, 1, 0, 0),
    "show_edge": False,
}

# What can be printed: the names of the tables, and what the run cost.
PARTS = ("detection", "localization", "safety", "costs")

Row = dict[Hashable, Any]
Manifest = dict[str, Any]


def print_summary(out: Path, console: Console, parts: Sequence[str] = PARTS) -> None:
    """Print `PARTS`, or some of them, of the run in the folder `out`.

    Table I's form (attack × detector), Tables II–IV's (attack × defence), what the errors would have meant, and what
    SUMO and the security layer cost.
    """
    runs = read_manifests(out)
    for part in parts:
        if part == "costs":
            console.print(_costs(runs, console))
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
        if scenario in (_name(run), base_name(_name(run))) and "plans" in run:
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
    if not _fits(table, console):
        caption = "intervals, told and never are in detection.csv"
        table = _detection_table(events, paper, wide=False)
    if any(paper.values()):
        caption += "; the paper's figures are for its own data and parameters"
    return Group(_title(f"Detection (form of Table I): {scenario}, profile {profile}"), table, _caption(caption))


def _detection_table(
    rows: pd.DataFrame, paper: Mapping[tuple[str, str], PublishedScores | None], *, wide: bool
) -> Table:
    """Return ours with intervals and the paper's in a column of their own, or else below ours and without intervals."""
    table = _table("attack", _HEADING_WIDTH if wide else _WIDEST_LABEL - 2)
    _add_label(table, "detector", _HEADING_WIDTH + 2)
    for heading in ("precision", "recall", "F1", "delay (s)", *(["paper P/R/F1 delay"] if wide else [])):
        table.add_column(heading, justify="right", no_wrap=True)
    for (attack,), group in _groups(rows, ["attack"]):
        lines = []
        for row in group.to_dict("records"):
            theirs = paper[attack, row["detector"]]
            if wide:
                lines.append([_short(row["detector"]), *_figures(row, _with_interval), _abreast(theirs)])
                continue
            lines.append([_short(row["detector"]), *_figures(row, _alone)])
            if theirs:
                lines.append(["  paper", *_published(theirs)])
        events = _counted(group["n_events"].iloc[0], "event")
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
    rates = [f"{row['detector']} {_number(row[name], '.2f')}" for row in first.to_dict("records")]
    hours = f"{first['vehicle_hours'].max():.2f} vehicle-hours without an attack"
    return f"False alarms per vehicle-hour: {scenario}, profile {profile} ({hours})\n{_filled(rates, console)}\n"


def _before_the_line(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> str:
    """Say of each attack how many were seen before the undefended vehicle would have touched a line."""
    said = [f"Seen before the undefended vehicle would have touched a line: {scenario}, profile {profile}"]
    for (attack,), group in _groups(rows[~rows["detector"].isin(_BOUNDS)], ["attack"]):
        events = int(group["n_line_events"].iloc[0])
        if events:
            shares = [f"{row['detector']} {row['seen_before_line_share']:.0%}" for row in group.to_dict("records")]
            said.append(_filled([f"{attack} ({events}):", *shares], console))
    return "\n".join(said) + "\n"


def _without_gnss(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> str:
    first = rows.drop_duplicates("defence")
    name = "isolated_minutes_per_vehicle_hour"
    said = [f"{row['defence']} {_number(row[name], '.2f')}" for row in first.to_dict("records")]
    heading = f"Minutes without GNSS per vehicle-hour without an attack: {scenario}, profile {profile}"
    return "\n".join([*rows["note"].dropna().unique(), heading, _filled(said, console), ""])


def _localization(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> Group:
    paper = localization_like(scenario, profile)
    extra: dict[str, dict[str, str]] = {}
    caption = "during the attack, none: over the whole settled life; never+none is without mitigation"
    if paper:
        figures = {UNDEFENDED: paper.undefended_m, "lstm+ukf": paper.mitigated_m, "lstm_glr+ukf": paper.mitigated_m}
        extra[f"paper, {paper.table}"] = {name: _triple(values) for name, values in figures.items()}
        caption += "; the paper's figures are for its own data and parameters, and it does not say which attack it is"
    return _matrix(
        f"RMSE x/y/xy in m (form of Tables II–IV): {scenario}, profile {profile}",
        rows[rows["n_vehicles"] > 0],
        lambda row: _triple([row["rmse_x_m"], row["rmse_y_m"], row["rmse_xy_m"]]),
        extra,
        caption,
        console,
    )


def _safety(scenario: str, profile: str, rows: pd.DataFrame, console: Console) -> Group:
    where = f"{scenario}, profile {profile}"
    return _matrix(
        f"Vehicles that would have touched a line/left their lane/gone the wrong way/left the road: {where}",
        rows[rows["n_vehicles"] > 0],
        lambda row: "/".join(_number(row[outcome], ".0f") for outcome in OUTCOMES),
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
    labels = min(max((len(label) for label in lines), default=0), _WIDEST_LABEL)
    labels = max(labels, _NARROWEST_LABEL)
    # A column takes its padding and the gap before it; the labels' takes only its padding.
    fitting = max(1, (console.width - labels - 1) // (max(widest, _HEADING_WIDTH) + 2))
    tables = []
    for start in range(0, len(defences), fitting):
        abreast = defences[start : start + fitting]
        table = _table("attack", labels)
        for name in abreast:
            table.add_column(_narrow(name), justify="right", no_wrap=True)
        for label, cells in lines.items():
            table.add_row(label, *(cells.get(name, "") for name in abreast))
        tables.append(table)
    return Group(_title(title), *tables, _caption(caption))


_COSTS = (
    "SUMO\n(s)",
    "reading\n(s)",
    "security\n(s)",
    "vehicle-\nsteps",
    "peak\nvehicles",
    "SUMO\n(µs)",
    "security\n(µs)",
)


def _costs(runs: Sequence[Manifest], console: Console) -> Group:
    table = _costs_table(runs, wide=True)
    lines = []
    if not _fits(table, console):
        table = _costs_table(runs, wide=False)
        lines = ["slowest stages (s)"]
        for run in runs:
            name, *others = _slowest(run) or [""]
            lines.append(_filled([f"{_name(run)}: {name}", *others], console))
    on_road = all("road_steps" in run for run in runs)
    vehicles = "all vehicles, equipped or not" if on_road else "the equipped vehicles"
    caption = (
        f"µs: for every vehicle and step, SUMO's over {vehicles}, security's over the equipped ones; "
        "security: all plans and defences together"
    )
    compiling = [f"{_name(run)} {run['compile_s']:.1f} s" for run in runs if run.get("compile_s", 0.0) > _SHORT_S]
    if compiling:
        caption += f"; compiling kernels, once, is in none of the figures: {', '.join(compiling)}"
    return Group(_title("What it cost"), table, *map(Text, lines), _caption(caption))


def _costs_table(runs: Sequence[Manifest], *, wide: bool) -> Table:
    table = _table("scenario", _WIDEST_LABEL)
    for name in _COSTS:
        table.add_column(name, justify="right", no_wrap=True)
    if wide:
        table.add_column("slowest stages\n(s)", overflow="fold", max_width=_STAGES_WIDTH)
    for run in runs:
        sumo_s, security_s = run.get("sumo_s"), sum(run.get("stages_s", {}).values())
        steps: int = run.get("vehicle_steps", 0)
        road_steps: int = run.get("road_steps", steps)
        table.add_row(
            _name(run),
            _number(sumo_s, ".1f"),
            _number(run.get("read_s"), ".1f"),
            f"{security_s:.1f}",
            f"{steps:,}",
            f"{run.get('peak_vehicles', 0):,}",
            _microseconds(sumo_s, road_steps),
            _microseconds(security_s, steps),
            *([", ".join(_slowest(run))] if wide else []),
        )
    return table


def _slowest(run: Manifest) -> list[str]:
    stages = sorted(run.get("stages_s", {}).items(), key=lambda item: -item[1])
    return [f"{name} {seconds:.1f}" for name, seconds in stages[:3]]


def _microseconds(seconds: float | None, steps: int) -> str:
    return _number(seconds / steps * 1e6 if seconds is not None and steps else None, ".1f")


def _name(run: Manifest) -> str:
    return str(run.get("scenario", ""))


def _title(text: str) -> Text:
    return Text(f"\n{text}", style="bold")


def _caption(text: str) -> Text:
    return Text(f"{text}\n", style="italic")


def _table(label: str, widest: int) -> Table:
    table = Table(**_FORM)
    _add_label(table, label, widest)
    return table


def _add_label(table: Table, heading: str, widest: int) -> None:
    """Add a column of names, which are folded where they are wider, and where figures need the room."""
    table.add_column(heading, overflow="fold", min_width=_NARROWEST_LABEL, max_width=widest)


def _fits(table: Table, console: Console) -> bool:
    """Say whether the console has room for all figures and for names as wide as they may be."""
    needed = Measurement.get(console, console.options.update(max_width=_UNLIMITED), table).maximum
    return needed <= console.width


def _filled(items: Iterable[str], console: Console) -> str:
    """Return items one after the other, indented, with line breaks between but never within them."""
    kept = "  ".join(item.replace(" ", "\N{NO-BREAK SPACE}") for item in items)
    filled = textwrap.fill(
        kept,
        console.width,
        initial_indent="  ",
        subsequent_indent="    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace("\N{NO-BREAK SPACE}", " ")


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


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
    if pd.isna(row[f"{name}_hi"]):
        return _alone(row, name)
    digits = 2 if row[f"{name}_hi"] < 9.995 else 1
    middle, low, high = (f"{row[key]:.{digits}f}" for key in (name, f"{name}_lo", f"{name}_hi"))
    return f"{middle} {low}–{high}"


def _alone(row: Row, name: str) -> str:
    return _number(row[name], ".2f" if row[name] < 9.995 else ".1f")


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
