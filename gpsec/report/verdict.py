"""The summary at the top of a report: outcomes, delays and false alarms, in sentences and one table."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from gpsec.report.figure_data import group_name
from gpsec.report.figures import defences_of
from gpsec.report.formatting import Record, figure, interval
from gpsec.running.results import Results
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED

# From this share on, it is all of them to the percent.
_ALL = 0.995


@dataclass(frozen=True)
class VerdictCell:
    """The results of one attack under one defence.

    Attributes:
        count, of: vehicles that would have left their lane, of those attacked.
        share: of them, 0 to 1.
        interval: of the share, in words.
        seen: median delay and share of the attacks seen, in words; empty where the detector is a bound.

    """

    count: int
    of: int
    share: float
    interval: str
    seen: str


@dataclass(frozen=True)
class Verdict:
    """The verdict on a scenario and sensor profile.

    Attributes:
        group: name of both.
        sentences: in plain words.
        defences: columns.
        false_alarms: of each defence's detector, in words; vehicle_hours: that they were counted in.
        rows: attack -> a cell for each defence.

    """

    group: str
    sentences: list[str]
    defences: list[str]
    false_alarms: list[str]
    vehicle_hours: float
    rows: dict[str, list[VerdictCell]]


def verdicts(run: Results) -> list[Verdict]:
    """Return the verdict on each scenario and sensor profile."""
    keys = ["scenario", "profile"]
    detection = dict(list(run.detection.groupby(keys, sort=False, observed=True)))
    order = defences_of(run)
    found = []
    for names, safety in run.safety.groupby(keys, sort=False, observed=True):
        scenario, profile = map(str, names)
        if not (safety["n_vehicles"] > 0).any():
            continue
        notes = safety["note"].dropna().unique()
        if len(notes):
            found.append(Verdict(group_name(scenario, profile), [f"{notes[0]}."], [], [], 0.0, {}))
            continue
        rates = detection[scenario, profile].to_dict("records")
        seen = {(row["attack"], row["detector"]): row for row in rates}
        here = set(safety["defence"])
        defences = [name for name in order if name in here]
        judged = safety[(safety["n_vehicles"] > 0) & (safety["attack"] != "none")].to_dict("records")
        attacked = {(row["attack"], row["defence"]): row for row in judged}
        rows = {
            attack: [_cell(attacked[attack, name], seen, attack, name) for name in defences]
            for attack in dict.fromkeys(str(row["attack"]) for row in judged)
        }
        once = {str(row["detector"]): row for row in rates}
        found.append(
            Verdict(
                group_name(scenario, profile),
                _sentences(rows, defences, once),
                defences,
                [_false_alarms(once, name.partition("+")[0]) for name in defences],
                max(float(row["vehicle_hours"]) for row in rates),
                rows,
            )
        )
    return found


def _cell(safety: Record, seen: dict[tuple[str, str], Record], attack: str, defence: str) -> VerdictCell:
    detector = defence.partition("+")[0]
    words = ""
    if detector not in BOUNDS and (attack, detector) in seen:
        row = seen[attack, detector]
        share = row["detected_share"]
        median_s = row["delay_median_s"]
        delay: str = "" if pd.isna(median_s) else f"seen after {median_s:.1f}\N{NO-BREAK SPACE}s"
        words = f"{delay}, {share:.0%} of them" if delay and share < _ALL else delay or "not seen"
    return VerdictCell(
        int(safety["out_of_lane"]),
        int(safety["n_vehicles"]),
        float(safety["out_of_lane_share"]),
        interval(safety, "out_of_lane_share", percent=True),
        words,
    )


def _false_alarms(once: Mapping[str, Record], detector: str) -> str:
    if detector in BOUNDS or detector not in once:
        return "none"
    row = once[detector]
    name = "false_alarms_per_vehicle_hour"
    return f"{figure(row[name])} ({interval(row, name)})"


def _sentences(rows: dict[str, list[VerdictCell]], defences: list[str], once: Mapping[str, Record]) -> list[str]:
    if not rows:
        return ["No vehicle was attacked, so there is nothing to judge but false alarms."]
    columns = {name: [cells[place] for cells in rows.values()] for place, name in enumerate(defences)}
    left = {name: sum(cell.count for cell in cells) for name, cells in columns.items()}
    total = sum(cell.of for cell in columns[defences[0]])
    said = []
    if UNDEFENDED in left:
        worst = max(rows, key=lambda attack: rows[attack][defences.index(UNDEFENDED)].share)
        cell = rows[worst][defences.index(UNDEFENDED)]
        said.append(
            f"Undefended, {left[UNDEFENDED]} of {total} attacks would have pushed the vehicle out of its lane"
            f" ({left[UNDEFENDED] / total:.0%}), most of all {worst} ({cell.count} of {cell.of})."
        )
    real = [name for name in defences if name.partition("+")[0] not in BOUNDS]
    if real:
        best = min(real, key=lambda name: left[name])
        detector = best.partition("+")[0]
        said.append(
            f"With {best}, the best of the defences here, {left[best]} would have ({left[best] / total:.0%});"
            f" its detector raised {_false_alarms(once, detector)} false alarms per vehicle-hour."
        )
    return said
