"""Writes the page and the Markdown of `gpsec stress`: each factor × each detector."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd

from gpsec.core.version import __version__
from gpsec.outcomes.tables import whole
from gpsec.paper.stress import is_bound
from gpsec.report.figure_data import Figure, Series, Values, colours
from gpsec.report.formatting import EMPTY, Record, figure, interval
from gpsec.report.page import render, write_page
from gpsec.report.tables import ReportTable, TableCell, TableRow
from gpsec.types.points import HEADLINE_RATE, without_rate

PAGE, MARKDOWN = "stress.html", "stress.md"
# On a logarithmic axis, no false alarm has this place.
_FEWEST_PER_H = 0.1


def write_stress(table: pd.DataFrame, name: str, folder: Path) -> list[Path]:
    """Write page and Markdown of a table, as `gpsec.paper.stress.run_stress` returns it, into `folder`."""
    attacks = [str(attack) for attack in table["attack"].unique() if attack != "none"]
    figures = {one.key: one for one in (_false_alarms(table), _touches(table), _delays(table))}
    page = render(
        "stress.html",
        {"figures": {key: one.plain() for key, one in figures.items()}, "groups": [name], "attacks": attacks},
        title=f"{name} under stress",
        figures=figures,
        tables=[_listing(table, name)],
        attacks=attacks,
        version=__version__,
    )
    write_page(folder / PAGE, page)
    with whole(folder / MARKDOWN) as partial:
        partial.write_text("\n".join(markdown(table)) + "\n", encoding="utf-8")
    return [folder / PAGE, folder / MARKDOWN]


def honest_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each factor and defence: what is the same under every attack."""
    return table.drop_duplicates(["factor", "detector", "response"])


def detector_rate(point: str) -> str:
    """Return the false-alarm rate of a detector that is named with it."""
    return point.partition("@")[2] or HEADLINE_RATE


def _defence(row: Record | pd.Series) -> str:
    return f"{row['detector']}+{row['response']}"


def _detectors(table: pd.DataFrame) -> list[str]:
    return [str(name) for name in table["detector"].unique() if not is_bound(str(name))]


def _false_alarms(table: pd.DataFrame) -> Figure:
    honest, key = honest_rows(table), "false_alarms_per_vehicle_hour"
    paint = colours(_detectors(table))
    series = []
    for detector in _detectors(table):
        mine = honest[honest["detector"] == detector].drop_duplicates("factor")
        bounds = [mine[f"{key}{end}"].clip(lower=_FEWEST_PER_H).tolist() for end in ("", "_lo", "_hi")]
        series.append(_points(detector, bounds, mine["title"].tolist(), paint[detector]))
    return _figure(
        "false_alarms",
        "False alarms of honest vehicles",
        "alarms that begin, per vehicle-hour",
        series,
        f"With intervals. None at all is drawn at {_FEWEST_PER_H:g}, the end of the axis.",
        {"type": "log"},
    )


def _touches(table: pd.DataFrame) -> Figure:
    honest = honest_rows(table)
    names = list(dict.fromkeys(_defence(row) for row in honest.to_dict("records")))
    paint = colours(names)
    series = []
    for name in names:
        mine = honest[honest["detector"] + "+" + honest["response"] == name]
        share = 100.0 * mine["line_touched"].astype(float) / mine["n_vehicles"]
        series.append(_points(name, [share.tolist()], mine["title"].tolist(), paint[name]))
    return _figure(
        "touches",
        "Honest vehicles that would have touched a line",
        "per cent of the vehicles",
        series,
        "Had they steered by their estimate. never is without a detector, told with one that is told the truth.",
        {"rangemode": "tozero"},
    )


def _delays(table: pd.DataFrame) -> Figure:
    paint = colours(_detectors(table))
    series = []
    for keys, rows in table[table["n_events"] > 0].groupby(["attack", "detector"], sort=False):
        attack, detector = map(str, keys)
        if is_bound(detector):
            continue
        mine = rows.drop_duplicates("factor")
        bounds = [mine[f"delay_mean_s{end}"].tolist() for end in ("", "_lo", "_hi")]
        series.append(_points(detector, bounds, mine["title"].tolist(), paint[detector], {"attack": attack}))
    return _figure(
        "delays",
        "Time to detect",
        "mean delay of the attacks that were seen (s)",
        series,
        "A detector that is nearly always in alarm is quick: look at its false alarms.",
        {"rangemode": "tozero"},
    )


def _points(
    name: str, bounds: list[list[float]], titles: Values, colour: int, where: dict[str, str] | None = None
) -> Series:
    low, high = (bounds[1], bounds[2]) if len(bounds) == 3 else (None, None)
    return Series(name, "points", bounds[0], titles, x_low=low, x_high=high, colour=colour, where=where or {})


def _figure(key: str, title: str, x_title: str, series: list[Series], note: str, axis: dict[str, object]) -> Figure:
    layout = {"xaxis": axis, "yaxis": {"autorange": "reversed", "type": "category"}}
    return Figure(key, title, x_title, "", series, "There is nothing to draw for this choice.", note, layout)


def _listing(table: pd.DataFrame, name: str) -> ReportTable:
    rows = []
    for row in table.to_dict("records"):
        cells = [
            TableCell(str(row["title"])),
            TableCell(figure(row["false_alarms_per_vehicle_hour"]), interval(row, "false_alarms_per_vehicle_hour")),
            TableCell(_touched(row)),
            TableCell(figure(row["detected_share"], percent=True), interval(row, "detected_share", percent=True)),
            TableCell(figure(row["delay_mean_s"]), interval(row, "delay_mean_s")),
            TableCell(figure(row["f1"]), interval(row, "f1")),
        ]
        rows.append(TableRow(str(row["attack"]), _defence(row), cells))
    headings = ["attack", "defence", "differs", "false alarms/h", "touched a line", "seen", "delay (s)", "F1"]
    return ReportTable(name, headings, rows, "False alarms and lines touched are of honest vehicles.")


def _touched(row: Record) -> str:
    return EMPTY if pd.isna(row["line_touched"]) else f"{int(row['line_touched'])}/{int(row['n_vehicles'])}"


def rates(table: pd.DataFrame) -> list[str]:
    """Return the false-alarm rates that detectors of the table have, the headline rate first."""
    found = {detector_rate(str(name)) for name in table["detector"].unique()}
    return sorted(found, key=lambda rate: (rate != HEADLINE_RATE, rate))


def markdown(table: pd.DataFrame) -> Iterator[str]:
    """Yield tables for each false-alarm rate: false alarms, honest vehicles that touch a line, and detection."""
    for rate in rates(table):
        mine = table[table["detector"].map(lambda name, wanted=rate: detector_rate(name) == wanted)]
        honest, detectors = honest_rows(mine), _detectors(mine)
        scored = honest[honest["detector"].isin(detectors)].drop_duplicates(["factor", "detector"])
        yield f"## Thresholds at {rate}"
        yield ""
        yield "False alarms per vehicle-hour of honest vehicles (alarms that begin):"
        yield from _pivot(scored, "detector", lambda row: figure(row["false_alarms_per_vehicle_hour"]))
        yield "Honest vehicles that would have touched a line, had they steered by their estimate:"
        yield from _pivot(honest.assign(defence=honest.apply(_defence, axis=1)), "defence", _touched)
        for attack in (name for name in mine["attack"].unique() if name != "none"):
            attacked = mine[(mine["attack"] == attack) & mine["detector"].isin(detectors)]
            yield f"`{attack}`: share seen, mean delay in seconds, F1:"
            yield from _pivot(attacked.drop_duplicates(["factor", "detector"]), "detector", _seen)


def _seen(row: Record) -> str:
    return f"{figure(row['detected_share'], percent=True)}, {figure(row['delay_mean_s'])}, {_three(row['f1'])}"


def _three(value: float) -> str:
    return EMPTY if pd.isna(value) else f"{value:.3f}"


def _pivot(table: pd.DataFrame, column: str, cell: Callable[[Record], str]) -> Iterator[str]:
    names = list(dict.fromkeys(table[column]))
    yield ""
    yield f"| differs | {' | '.join(f'`{without_rate(str(name))}`' for name in names)} |"
    yield f"|---|{'---|' * len(names)}"
    for title, rows in table.groupby("title", sort=False):
        found = {row[column]: cell(row) for row in rows.to_dict("records")}
        yield f"| {title} | {' | '.join(found.get(name, EMPTY) for name in names)} |"
    yield ""
