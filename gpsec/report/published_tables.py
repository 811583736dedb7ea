"""The tables of `gpsec table`: what goes from a run into a paper, with the numbers that its caption needs."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import astuple

import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.outcomes.paper import TABLE_I
from gpsec.outcomes.ranking import Ranking
from gpsec.report.formatting import EMPTY, Record, figure, interval
from gpsec.report.gathering import Gathered
from gpsec.report.matched_table import matched_tables
from gpsec.report.typesetting import TypesetTable, label, ruled
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import detector_at

_METRICS = ("precision", "recall", "f1", "delay_mean_s")
_HEADINGS = ("P", "R", "F1", "delay (s)")
# The detectors of the paper's Table I, and ours that stand for them.
_OF_TABLE_I = {"cusum": ("cusum",), "isolation_forest": ("isolation_forest",), "lstm": ("lstm", "lstm_glr")}


def make_tables(name: str, found: Gathered) -> list[TypesetTable]:
    """Return the tables of one of `TABLES_FOR_PAPERS`, one for each scenario and profile.

    Raises:
        GpsecError: there is none of that name, or the runs have nothing to show in it.
    """
    if name not in TABLES_FOR_PAPERS:
        raise GpsecError(f"--name: unknown table '{shown(name)}': {nearest(name, TABLES_FOR_PAPERS)}")
    made = [table for table in TABLES_FOR_PAPERS[name](found) if table.rows]
    if not made:
        raise GpsecError(f"table '{name}': expected runs with something to show in it, found none")
    return made


def _groups(table: pd.DataFrame) -> Iterator[tuple[str, str, list[Record]]]:
    for keys, rows in table.groupby(["scenario", "profile"], sort=False):
        scenario, profile = map(str, keys)
        yield scenario, profile, rows.to_dict("records")


def _with_interval(row: Record, name: str, *, percent: bool = False) -> str:
    text, bounds = figure(row[name], percent=percent), interval(row, name, percent=percent)
    return f"{text} ({bounds})" if bounds and text != EMPTY else text


def _table_one(found: Gathered) -> Iterator[TypesetTable]:
    """Yield Table I in its own form: two attacks × three detectors, the paper's figures and ours side by side."""
    for scenario, profile, rows in _groups(found.tables["detection"]):
        known: dict[tuple[str, str], Record] = {}
        for row in rows:
            known.setdefault((found.plans.get(row["attack"], row["attack"]), row["detector"]), row)
        lines: list[list[str] | None] = []
        events = 0
        for attack in dict.fromkeys(attack for attack, _ in TABLE_I):
            group = []
            for theirs, ours in _OF_TABLE_I.items():
                published = [figure(value) for value in astuple(TABLE_I[attack, theirs])]
                points = [row for (a, name), row in known.items() if a == attack and detector_at(name) in ours]
                for row in points:
                    events = max(events, int(row["n_events"]))
                    group.append([attack, str(row["detector"]), *published, *(figure(row[key]) for key in _METRICS)])
            lines += [*([None] if lines and group else []), *group]
        caption = (
            f"Detection in the form of the paper's Table I, {scenario}, profile {profile}: its figures and ours;"
            f" n = {events} events an attack, {found.caption(scenario)}. The paper's are for its own data and"
            " parameters."
        )
        headings = [
            "attack",
            "detector",
            *(f"{name}, paper" for name in _HEADINGS),
            *(f"{n}, gpsec" for n in _HEADINGS),
        ]
        yield TypesetTable(label("table1", scenario, profile), caption, headings, lines)


def _detection(found: Gathered) -> Iterator[TypesetTable]:
    for scenario, profile, rows in _groups(found.tables["detection"]):
        mine = [row for row in rows if row["n_events"] > 0 and row["detector"] not in BOUNDS]
        lines = [
            [
                *(str(row["attack"]), str(row["detector"])),
                *(_with_interval(row, key) for key in _METRICS),
                _with_interval(row, "detected_share", percent=True),
                _with_interval(row, "false_alarms_per_vehicle_hour"),
            ]
            for row in mine
        ]
        n = max((int(row["n_events"]) for row in mine), default=0)
        caption = (
            f"Detection, {scenario}, profile {profile}; n = up to {n} events an attack, {found.caption(scenario)}."
        )
        headings = ["attack", "detector", *_HEADINGS, "seen", "false alarms per vehicle-hour"]
        yield TypesetTable(label("detection", scenario, profile), caption, headings, ruled(lines))


def _outcomes(found: Gathered) -> Iterator[TypesetTable]:
    for scenario, profile, rows in _groups(found.tables["safety"]):
        mine = [row for row in rows if row["n_vehicles"] > 0 and not pd.isna(row["out_of_lane_share"])]
        keys = ("line_touched_share", "out_of_lane_share", "wrong_way_share", "off_road_share")
        lines = [
            [str(row["attack"]), str(row["defence"]), str(int(row["n_vehicles"]))]
            + [_with_interval(row, key, percent=True) for key in keys]
            for row in mine
        ]
        caption = (
            f"What attacks would have meant, {scenario}, profile {profile}; n vehicles, {found.caption(scenario)}."
        )
        headings = ["attack", "defence", "n", "line touched", "out of lane", "wrong way", "off the road"]
        yield TypesetTable(label("outcomes", scenario, profile), caption, headings, ruled(lines))


def _localization(found: Gathered) -> Iterator[TypesetTable]:
    keys = ("rmse_x_m", "rmse_y_m", "rmse_xy_m", "rmse_cross_track_m")
    for scenario, profile, rows in _groups(found.tables["localization"]):
        mine = [row for row in rows if row["n_vehicles"] > 0]
        lines = [
            [
                str(row["attack"]),
                str(row["defence"]),
                str(int(row["n_vehicles"])),
                *(_with_interval(row, k) for k in keys),
            ]
            for row in mine
        ]
        caption = f"Position error (RMSE), {scenario}, profile {profile}; n vehicles, {found.caption(scenario)}."
        headings = ["attack", "defence", "n", "x (m)", "y (m)", "xy (m)", "across (m)"]
        yield TypesetTable(label("localization", scenario, profile), caption, headings, ruled(lines))


def _defences(found: Gathered) -> Iterator[TypesetTable]:
    for ranking in found.ranked:
        if not ranking.best:
            continue
        lines: list[list[str] | None] = []
        for each in sorted(ranking.standings.values(), key=lambda each: each.share):
            against = each.against
            difference = f"{100 * against.mean:.1f} ({100 * against.low:.1f} – {100 * against.high:.1f})"
            lines.append(
                [
                    "best" if each.defence in ranking.best else "",
                    each.defence,
                    f"{figure(each.share, percent=True)} ({figure(each.low, percent=True)} –"
                    f" {figure(each.high, percent=True)})",
                    "" if each.defence == ranking.best[0] else difference,
                    figure(each.in_time_share, percent=True),
                    figure(each.false_alarms_per_h),
                    figure(each.without_gnss_min_per_h),
                ]
            )
        yield TypesetTable(
            label("defences", ranking.scenario, ranking.profile), _ranked_caption(ranking, found), _RANKED, lines
        )


_RANKED = (
    *("", "defence", "out of lane", "less the first (points of %)", "alarm before the line"),
    *("false alarms per vehicle-hour", "min without GNSS per vehicle-hour"),
)


def _ranked_caption(ranking: Ranking, found: Gathered) -> str:
    apart = f"; apart from {', '.join(ranking.apart)}" if ranking.apart else ""
    plain = "" if ranking.helps else f"; none can be told apart from {UNDEFENDED}"
    return (
        f"Defences by the mean share of a vehicle's attacks that put it out of its lane, {ranking.scenario}, profile"
        f" {ranking.profile}; n = {ranking.vehicles} vehicles, {len(ranking.attacks)} attacks{apart}; best: those that"
        f" pairs of the same vehicle do not tell apart from the first{plain}; differences with simultaneous bounds;"
        f" {found.caption(ranking.scenario)}."
    )


TABLES_FOR_PAPERS: Mapping[str, Callable[[Gathered], Iterator[TypesetTable]]] = {
    "table1": _table_one,
    "detection": _detection,
    "matched": matched_tables,
    "localization": _localization,
    "outcomes": _outcomes,
    "defences": _defences,
}
"""What `gpsec table` makes, by name."""
