"""The tables of a report: detection as in the paper's Table I, localization as in its Tables II to IV, and outcomes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from gpsec.outcomes.paper import detection_like, localization_like
from gpsec.outcomes.state import OUTCOMES
from gpsec.report.figure_data import group_name
from gpsec.report.figures import defences_of
from gpsec.report.formatting import EMPTY, Record, figure, interval, lacked
from gpsec.running.results import Results
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import detector_at

_RATES = {
    "precision": "precision",
    "recall": "recall",
    "F1": "f1",
    "mean delay (s)": "delay_mean_s",
    "seen": "detected_share",
    "seen before the line": "seen_before_line_share",
    "alarm ends after (s)": "alarm_ends_after_mean_s",
}
_PERCENT = {"seen", "seen before the line"}
_ERRORS = {
    "x (m)": "rmse_x_m",
    "y (m)": "rmse_y_m",
    "xy (m)": "rmse_xy_m",
    "across (m)": "rmse_cross_track_m",
    "along (m)": "rmse_along_track_m",
}


@dataclass(frozen=True)
class TableCell:
    """A figure and the small print under it."""

    text: str
    small: str = ""


@dataclass(frozen=True)
class TableRow:
    """A row of a table.

    Attributes:
        attack, name: its first two cells.
        cells: the others.
        published: it is the paper's.

    """

    attack: str
    name: str
    cells: Sequence[TableCell]
    published: bool = False


@dataclass(frozen=True)
class ReportTable:
    """A table of one scenario and profile; the caption says what has to be known to read it."""

    group: str
    headings: Sequence[str]
    rows: Sequence[TableRow]
    caption: str


def detection_tables(run: Results) -> list[ReportTable]:
    """Return Table I's form: attack × detector, the paper's rows where it has them."""
    made = []
    compared = run.detection[(run.detection["n_events"] > 0) & ~run.detection["detector"].isin(BOUNDS)]
    for (scenario, profile), rows in by_group(compared):
        attacks = {plan["name"]: plan["attack"] for plan in run.manifest(scenario).get("plans", [])}
        lines = []
        for row in rows:
            cells = [_measured(row, name, percent=heading in _PERCENT) for heading, name in _RATES.items()]
            cells += [TableCell(lacked(row["roc_auc"])), TableCell(lacked(row["pr_auc"]))]
            cells += [TableCell(figure(row["matched_recall"])), _measured(row, "false_alarms_per_vehicle_hour")]
            lines.append(TableRow(row["attack"], row["detector"], cells))
            paper = detection_like(str(attacks.get(row["attack"], row["attack"])), detector_at(str(row["detector"])))
            if paper is not None:
                published = [paper.precision, paper.recall, paper.f1, paper.delay_s]
                cells = [*(TableCell(figure(value)) for value in published), *[TableCell("")] * 7]
                lines.append(TableRow(row["attack"], "the paper's", cells, published=True))
        headings = ["attack", "detector", *_RATES, "1 − ROC area", "1 − PR area"]
        headings += ["recall at the matched rate", "false alarms per vehicle-hour"]
        caption = (
            "Samples of attacked vehicles. Seen before the line: of the attacks under which an undefended vehicle would"
            " have touched a line. Matched: at the threshold that benign vehicles of this very run ask for; left out"
            " where they are too few for that. told and never, which frame the others, are in detection.csv."
        )
        if any(line.published for line in lines):
            caption += " The paper's figures are for its own data and parameters."
        made.append(ReportTable(group_name(scenario, profile), headings, lines, caption))
    return made


def localization_tables(run: Results) -> list[ReportTable]:
    """Return the form of Tables II to IV: attack × defence, the paper's rows where its set-up is like ours."""
    made = []
    order = {name: i for i, name in enumerate(defences_of(run))}
    for (scenario, profile), rows in by_group(run.localization[run.localization["n_vehicles"] > 0]):
        lines = []
        for row in _undefended_first(rows, order):
            cells = [*(_measured(row, name) for name in _ERRORS.values())]
            cells += [TableCell(figure(row["max_cross_track_m"])), TableCell(figure(row["twin_rmse_xy_m"]))]
            lines.append(TableRow(row["attack"], row["defence"], cells))
        caption = (
            "Root of the mean squared error, during the attack; under none, over the settled life. The twin is the same"
            " vehicle with the same defence and without the attack, in the same steps."
        )
        paper = localization_like(scenario, profile)
        if paper is not None:
            for name, values in ((UNDEFENDED, paper.undefended_m), ("lstm+ukf", paper.mitigated_m)):
                cells = [*(TableCell(figure(value)) for value in values), *[TableCell("")] * 4]
                lines.append(TableRow(f"the paper's {paper.table}", name, cells, published=True))
            caption += " The paper's figures are for its own data, and it does not say which attack they are for."
        headings = ["attack", "defence", *_ERRORS, "largest across (m)", "twin's xy (m)"]
        made.append(ReportTable(group_name(scenario, profile), headings, lines, caption))
    return made


def safety_tables(run: Results) -> list[ReportTable]:
    """Return how many vehicles would have reached each outcome: attack × defence."""
    made = []
    order = {name: i for i, name in enumerate(defences_of(run))}
    for (scenario, profile), rows in by_group(run.safety[run.safety["n_vehicles"] > 0]):
        lines = []
        for row in _undefended_first(rows, order):
            cells = [TableCell(str(row["n_vehicles"]))]
            for name in OUTCOMES:
                share = figure(row[f"{name}_share"], percent=True)
                count: str = EMPTY if pd.isna(row[name]) else f"{row[name]:.0f} ({share})"
                cells.append(TableCell(count, interval(row, f"{name}_share", percent=True)))
            cells += [_measured(row, f"{name}_caused_share", percent=True) for name in OUTCOMES[:2]]
            cells.append(_measured(row, "isolated_minutes_per_vehicle_hour"))
            lines.append(TableRow(row["attack"], row["defence"], cells))
        headings = ["attack", "defence", "vehicles", *(name.replace("_", " ") for name in OUTCOMES)]
        headings += ["line touches caused", "lane departures caused", "minutes without GNSS per benign hour"]
        caption = "Vehicles that would have, had they steered by their estimate; none is what GNSS and false alarms do."
        caption += " Caused: more than their benign twins in the same time."
        caption += "".join(f" Left out: {row['note']}." for row in rows[:1] if not pd.isna(row["note"]))
        made.append(ReportTable(group_name(scenario, profile), headings, lines, caption))
    return made


def by_group(table: pd.DataFrame) -> Iterable[tuple[tuple[str, str], list[Record]]]:
    """Return the rows of each scenario and profile."""
    found: dict[tuple[str, str], list[Record]] = {}
    for row in table.to_dict("records"):
        found.setdefault((row["scenario"], row["profile"]), []).append(row)
    return found.items()


def _undefended_first(rows: list[Record], order: Mapping[str, int]) -> list[Record]:
    attacks = list(dict.fromkeys(row["attack"] for row in rows))
    return sorted(rows, key=lambda row: (attacks.index(row["attack"]), order[row["defence"]]))


def _measured(row: Record, name: str, *, percent: bool = False) -> TableCell:
    text = figure(row[name], percent=percent)
    return TableCell(text, "" if text == EMPTY else interval(row, name, percent=percent))
