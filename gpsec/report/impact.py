"""How far attacks get before anybody notices, at which rate of false alarms: a table of the report."""

import pandas as pd

from gpsec.outcomes.reading import bootstrap_of
from gpsec.report.figure_data import group_name
from gpsec.report.formatting import EMPTY, Record, figure, interval
from gpsec.report.tables import ReportTable, TableCell, TableRow, by_group
from gpsec.running.impact import GONE_UNSEEN, impact_table
from gpsec.running.results import Results

_CAPTION = (
    "The largest error across the lane of an undefended vehicle under attack, before the detector's first alarm or in"
    " the whole attack where there is none: the damage that goes unseen, beside the false alarms that the detector had"
    " in this run. Median and 95 % quantile over vehicles; shares are of attacked vehicles. With several seeds,"
    " intervals are of a bootstrap of runs, then vehicles. never is a vehicle that nobody watches."
)
_HEADINGS = ("attack", "detector", "false alarms per vehicle-hour", "seen", "unseen (m), median", "95 %", "after (s)")


def impact_tables(run: Results) -> list[ReportTable]:
    """Return attack × detector, over all seeds of a scenario."""
    table = impact_table(run.tables, bootstrap_of(run.scenarios[0]))
    headings = [*_HEADINGS, *(f"{name.replace('_', ' ')} unseen" for name in GONE_UNSEEN)]
    made = []
    for (scenario, profile), rows in by_group(table):
        lines = [TableRow(str(row["attack"]), str(row["detector"]), _cells(row)) for row in rows]
        made.append(ReportTable(group_name(scenario, profile), headings, lines, _CAPTION))
    return made


def _cells(row: Record) -> list[TableCell]:
    return [
        _bounded(row, "false_alarms_per_vehicle_hour"),
        _bounded(row, "detected_share", percent=True),
        _bounded(row, "max_undetected_deviation_median_m"),
        *(TableCell(figure(row[f"max_undetected_deviation_{name}"])) for name in ("p95_m", "median_s")),
        *(_bounded(row, f"{name}_unseen_share", percent=True) for name in GONE_UNSEEN),
    ]


def _bounded(row: Record, name: str, *, percent: bool = False) -> TableCell:
    text = figure(row[name], percent=percent)
    return TableCell(text, "" if pd.isna(row[name]) or text == EMPTY else interval(row, name, percent=percent))
