"""Writes the page "profile against log": what a log says of each sensor, beside what its profile says of the same."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.errors import GpsecError, shown
from gpsec.core.version import __version__
from gpsec.outcomes.tables import LOG_ERRORS, LOG_TAPE
from gpsec.report.figure_data import NEUTRAL, Figure, Series
from gpsec.report.formatting import EMPTY
from gpsec.report.page import render, write_page
from gpsec.report.tables import ReportTable, TableCell, TableRow
from gpsec.types.tapes import read_tape

LOG_PAGE = "log.html"
# A figure that a log can judge is marked where it is off by more.
FACTOR = 2.0
_LAG = re.compile(r"√structure ([0-9.]+) s")
_MOST_POINTS, _LARGEST = 4000, 1e12
_NUMBERS = ("value", "value_lo", "value_hi", "n", "profile_says")
_NEEDED = ("scenario", "sensor", "axis", "figure", "unit", "value", "value_lo", "value_hi", "n", "profile_says", "key")


def write_log_page(folder: Path) -> Path | None:
    """Write the page of a replayed run into its folder and return where it is; None where no log has sensors.

    Raises:
        GpsecError: a table is not as `gpsec replay` writes it, or the page cannot be written.
    """
    file = folder / f"{LOG_ERRORS}.csv"
    if not file.is_file():
        return None
    table = _read(file)
    names = [str(name) for name in table["scenario"].unique()]
    figures = {one.key: one for one in (_structure(table), _over_time(folder, names))}
    page = render(
        "log.html",
        {"figures": {key: one.plain() for key, one in figures.items()}, "groups": names, "attacks": []},
        title="profile against log",
        figures=figures,
        groups=names,
        tables=[_listing(name, rows) for name, rows in table.groupby("scenario", sort=False)],
        version=__version__,
    )
    write_page(folder / LOG_PAGE, page)
    return folder / LOG_PAGE


def _read(file: Path) -> pd.DataFrame:
    try:
        table = pd.read_csv(file, dtype=str, keep_default_na=False)
    except (OSError, ValueError) as error:
        raise GpsecError(f"{file}: expected figures of a log, found none: {shown(str(error))}") from None
    if missing := [name for name in _NEEDED if name not in table]:
        raise GpsecError(f"{file}: {missing[0]}: expected this column, found none")
    return table.assign(**{name: _numbers(file, table[name]) for name in _NUMBERS})


def _numbers(file: Path, cells: "pd.Series[str]") -> "pd.Series[float]":
    """Return the numbers in a column, NaN where a cell is empty."""
    numbers = pd.to_numeric(cells.where(cells != "", "nan"), errors="coerce")
    wrong = (numbers.isna() & (cells != "")) | (numbers.abs() > _LARGEST)
    if wrong.any():
        raise GpsecError(f"{file}: {cells.name}: expected numbers, found '{shown(cells[wrong].iloc[0])}'")
    return numbers


def _structure(table: pd.DataFrame) -> Figure:
    series: list[Series] = []
    found = table[table["figure"].str.fullmatch(_LAG.pattern)].dropna(subset=["value"])
    for (name, axis), rows in found.groupby(["scenario", "axis"], sort=False):
        lags = [float(_LAG.fullmatch(text)[1]) for text in rows["figure"]]  # type: ignore[index]
        where = {"group": str(name), "axis": str(axis)}
        low, high = rows["value_lo"].tolist(), rows["value_hi"].tolist()
        series.append(Series("log", "points", lags, rows["value"].tolist(), low=low, high=high, colour=0, where=where))
        series.append(Series("profile", "line", lags, rows["profile_says"].tolist(), colour=1, where=where))
    return Figure(
        "structure",
        "How far the error of fixes goes in a time",
        "lag (s)",
        "√⟨(e(t + lag) − e(t))²⟩ (m)",
        series,
        "The log has no fixes, or is too short.",
        "With intervals of 95 %. White noise is level at √2·σ; a bias grows with the root of the lag, a smooth wander"
        " with the lag itself.",
        {"xaxis": {"type": "log"}, "yaxis": {"type": "log"}},
    )


def _over_time(folder: Path, names: list[str]) -> Figure:
    series: list[Series] = []
    for name in names:
        alone = folder / LOG_TAPE
        file = alone if alone.is_file() else folder / f"{Path(LOG_TAPE).stem}-{name}{Path(LOG_TAPE).suffix}"
        if not file.is_file():
            continue
        tape, _ = read_tape(file)
        piece = np.searchsorted(tape.piece, np.arange(len(tape.missing)), side="right") - 1
        errors = np.where(tape.missing[:, None], np.nan, tape.errors + tape.median[piece])
        kept = slice(None, None, max(len(errors) // _MOST_POINTS, 1))
        time_s = np.arange(len(errors))[kept] / tape.rate_hz
        for column, axis in enumerate(("east", "north")):
            series.append(Series(axis, "line", time_s, errors[kept, column], colour=column, where={"group": name}))
        series.append(Series("0", "line", [0.0, float(time_s[-1])], [0.0, 0.0], colour=NEUTRAL, where={"group": name}))
    return Figure(
        "time",
        "Errors of fixes",
        "time in the log (s); pieces follow each other without their gaps",
        "measured less true (m)",
        series,
        "The log has no fixes.",
        "Against the log's own reference, whose error is in it.",
    )


def _listing(name: object, rows: pd.DataFrame) -> ReportTable:
    return ReportTable(
        str(name),
        ["sensor", "figure", "log", "profile", "log over profile", "key of the profile"],
        list(_rows(rows)),
        f"What is off by more than a factor of {FACTOR:g} is marked; intervals are of 95 %.",
    )


def _rows(rows: pd.DataFrame) -> Iterator[TableRow]:
    for row in rows.to_dict("records"):
        unit = f" {row['unit']}" if row["unit"] else ""
        small = "" if pd.isna(row["value_lo"]) else f"{row['value_lo']:.3g} – {row['value_hi']:.3g}"
        yield TableRow(
            f"{row['sensor']} {row['axis']}".strip(),
            str(row["figure"]),
            [
                TableCell(_number(row["value"], unit), small),
                TableCell(_number(row["profile_says"], unit)),
                TableCell(times_said(row["value"], row["profile_says"])),
                TableCell(str(row["key"])),
            ],
        )


def _number(value: float, unit: str) -> str:
    return EMPTY if pd.isna(value) else f"{value:.3g}{unit}"


def times_said(found: float, says: float) -> str:
    """Return how many times a profile's figure a log's is, marked where it is off by more than `FACTOR`."""
    if pd.isna(found) or pd.isna(says) or found == 0.0 or says == 0.0:
        return EMPTY
    times = abs(found / says)
    mark = "" if 1.0 / FACTOR <= times <= FACTOR else " ▲" if times > 1.0 else " ▼"
    return f"{times:.2g}×{mark}"
