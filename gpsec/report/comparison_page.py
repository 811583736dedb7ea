"""Writes the page that compares two runs."""

from collections.abc import Hashable
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.version import __version__
from gpsec.report.comparison import FALSE_ALARMS, comparison, pairs
from gpsec.report.figure_data import Figure, Series, colours, group_name
from gpsec.report.formatting import figure, interval
from gpsec.report.page import render, write_page
from gpsec.report.tables import ReportTable, TableCell, TableRow
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import HEADLINE_RATE, point_name

COMPARISON = "comparison.html"


def write_comparison(first: Results, second: Results, path: Path | None = None) -> Path:
    """Write the comparison of two runs into the folder of the second, or to `path`, and return where it is.

    Raises:
        GpsecError: no vehicle is in both.
    """
    found = comparison(first, second)
    shared, alone = pairs(first, second)
    groups = list(dict.fromkeys(group_name(*pair) for pair in zip(found["scenario"], found["profile"], strict=True)))
    attacks = list(dict.fromkeys(found["attack"]))
    figures = {"difference": _figure(found)}
    page = render(
        "comparison.html",
        {"figures": {key: one.plain() for key, one in figures.items()}, "groups": groups, "attacks": attacks},
        title="two runs compared",
        names=(first.folder.resolve().name, second.folder.resolve().name),
        unlike=_unlike(first, second),
        count=len(shared),
        alone=alone,
        figures=figures,
        tables=_tables(found),
        groups=groups,
        attacks=attacks,
        version=__version__,
    )
    target = path or second.folder / COMPARISON
    write_page(target, page)
    return target


def _figure(found: pd.DataFrame) -> Figure:
    colour = colours(found["defence"], UNDEFENDED)
    series = []
    keys = ["scenario", "profile", "attack", "figure", "defence"]
    for names, rows in found.groupby(keys, sort=False):
        scenario, profile, attack, name, defence = map(str, names)
        series.append(
            Series(
                defence,
                "points",
                rows["difference"].tolist(),
                [defence],
                x_low=rows["difference_lo"].tolist(),
                x_high=rows["difference_hi"].tolist(),
                colour=colour[defence],
                where={"group": group_name(scenario, profile), "attack": attack, "figure": name},
            )
        )
    return Figure(
        "difference",
        "Difference: second run − first run",
        "difference, with its interval",
        "",
        series,
        "No vehicle of this scenario was attacked in this way in both runs, or none has this figure.",
        f"Pairs of the same vehicle, resampled together. Under none: {FALSE_ALARMS}.",
        {"xaxis": {"zeroline": True, "zerolinewidth": 2}, "yaxis": {"autorange": "reversed"}},
    )


def _tables(found: pd.DataFrame) -> list[ReportTable]:
    headings = ["attack", "defence", "figure", "vehicles", "first run", "second run", "difference"]
    grouped: dict[str, list[TableRow]] = {}
    for row in found.to_dict("records"):
        cells = [
            TableCell(str(row["figure"])),
            TableCell(str(row["n_vehicles"])),
            TableCell(figure(row["first"])),
            TableCell(figure(row["second"])),
            TableCell(_signed(row), interval(row, "difference")),
        ]
        grouped.setdefault(group_name(row["scenario"], row["profile"]), []).append(
            TableRow(str(row["attack"]), str(row["defence"]), cells)
        )
    caption = "Means of the pairs; the difference is second − first, with its interval by bootstrap over vehicles."
    return [ReportTable(group, headings, rows, caption) for group, rows in grouped.items()]


def _signed(row: dict[Hashable, Any]) -> str:
    text = figure(row["difference"])
    return f"+{text}" if row["difference"] > 0.0 and text != figure(0.0) else text


def _unlike(first: Results, second: Results) -> list[str]:
    """Return sentences on the settings that differ between the runs, and on tables that were changed after the run."""
    said = [f"{run.folder.name}/{name} is {state}" for run in (first, second) for name, state in run.changed.items()]
    others = {stated["scenario"]: stated for stated in second.scenarios}
    for stated in first.scenarios:
        name = stated["scenario"]
        if name not in others:
            said.append(f"{name} is in the first run only")
            continue
        mine, theirs = (_flat(one["configuration"]) for one in (stated, others[name]))
        for key in dict.fromkeys([*mine, *theirs]):
            if mine.get(key) != theirs.get(key):
                said.append(f"{name}: {key} is {mine.get(key, 'unset')}, then {theirs.get(key, 'unset')}")
        if stated["git_commit"] != others[name]["git_commit"]:
            said.append(f"{name}: gpsec's commit is {stated['git_commit']}, then {others[name]['git_commit']}")
    known = {stated["scenario"] for stated in first.scenarios}
    said += [f"{name} is in the second run only" for name in others if name not in known]
    return said


def _flat(value: Any, prefix: str = "") -> dict[str, str]:
    if isinstance(value, dict):
        items = [(str(key), part) for key, part in value.items()]
    elif isinstance(value, list):
        items = [(_name(part, place), part) for place, part in enumerate(value)]
    else:
        return {prefix: str(value)}
    flat: dict[str, str] = {}
    for key, part in items:
        flat |= _flat(part, f"{prefix}.{key}" if prefix else key)
    return flat


def _name(part: Any, place: int) -> str:
    """Return the key of a list item: the name of a plan or defence, so that order does not matter, or its place."""
    if isinstance(part, dict) and "name" in part:
        return str(part["name"])
    if isinstance(part, dict) and {"detector", "response"} <= set(part):
        return f"{point_name(part['detector'], part.get('rate', HEADLINE_RATE))}+{part['response']}"
    return str(place)
