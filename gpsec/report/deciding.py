"""The page for deciding: false alarms a day of a fleet against vehicles out of their lane, for each rate."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gpsec.outcomes.paired import named_together
from gpsec.outcomes.ranking import Ranking, Standing, of_group
from gpsec.report.figure_data import Figure, Series, colours, group_name
from gpsec.report.formatting import figure
from gpsec.report.tables import ReportTable, TableCell, TableRow
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import HEADLINE_RATE, without_rate

FLEET_HOURS = 1000.0
"""Hours that a fleet drives in a day, where none are stated: of 1,000 vehicles an hour each."""
# On a logarithmic axis, no false alarm has the place of a tenth of the smallest rate that is shown.
_NONE = 0.1
_MANY = 12


@dataclass(frozen=True)
class Advice:
    """What can be said of a scenario and profile; group is the name of both."""

    group: str
    sentences: list[str]


def decision_figure(run: Results, ranked: Sequence[Ranking], fleet_hours: float) -> Figure:
    """Return false alarms a day in `fleet_hours` against the share out of lane, a line for each defence's rates."""
    names = [name for ranking in ranked for name in ranking.standings if _can_choose(name)]
    colour = colours(without_rate(name) for name in names)
    series = []
    for ranking in ranked:
        rates = _rates(run, ranking)
        where = {"group": group_name(ranking.scenario, ranking.profile)}
        for defence in dict.fromkeys(without_rate(name) for name in ranking.standings if _can_choose(name)):
            points = [each for name, each in ranking.standings.items() if without_rate(name) == defence]
            points.sort(key=lambda each: rates[each.defence][0])
            a_day = np.array([rates[each.defence] for each in points]) * fleet_hours
            shown = np.maximum(a_day, _NONE)
            share, low, high = (np.array([getattr(each, key) for each in points]) for key in ("share", "low", "high"))
            text = [f"{each.defence}: {figure(each.share, percent=True)}" for each in points]
            drawn = Series(defence, "trail", shown[:, 0], share, low, high, shown[:, 1], shown[:, 2])
            series.append(replace(drawn, colour=colour[defence], where=where, text=text))
    return Figure(
        "decision",
        "What protection costs",
        f"false alarms a day, of a fleet that drives {fleet_hours:g} hours",
        "share out of lane",
        series,
        "Nothing was attacked across the road, so there is nothing to decide.",
        "The mean over vehicles of the share of its attacks that put it out of its lane."
        f" A line for each defence, a point for each of its false-alarm rates ({HEADLINE_RATE} is what one would drive"
        f" with). None in this run is drawn at {_NONE:g} a day; its interval says how many there may be."
        " gpsec run --rates 1/h,0.1/h,1e-3/sample gives every defence these rates; gpsec report --fleet-hours states"
        " another fleet.",
        {"xaxis": {"type": "log"}, "yaxis": {"rangemode": "tozero", "tickformat": ".0%"}},
        tall=True,
    )


def decision_tables(run: Results, ranked: Sequence[Ranking], fleet_hours: float) -> list[ReportTable]:
    """Return a row for each operating point: threshold, false alarms a day, vehicles out of lane, time without GNSS."""
    made = []
    for ranking in ranked:
        if not ranking.best:
            continue
        detection = of_group(run.detection, ranking.scenario, ranking.profile).drop_duplicates("detector")
        known = {str(row["detector"]): row for row in detection.to_dict("records")}
        rates = _rates(run, ranking)
        order = sorted(ranking.standings.values(), key=lambda each: each.share)
        lines = []
        for each in order:
            if not _can_choose(each.defence) and each.defence != UNDEFENDED:
                continue
            row = known.get(each.defence.partition("+")[0], {})
            a_day = [rate * fleet_hours for rate in rates[each.defence]]
            alarms = TableCell(figure(a_day[0]), f"{figure(a_day[1])} – {figure(a_day[2])}")
            threshold = TableCell(
                figure(row.get("threshold", np.nan)), "" if row.get("rate") != row.get("rate") else str(row["rate"])
            )
            cells = [
                *((TableCell("none"), TableCell("none")) if _never_alarms(each.defence) else (threshold, alarms)),
                TableCell(
                    figure(each.share, percent=True),
                    f"{figure(each.low, percent=True)} – {figure(each.high, percent=True)}",
                ),
                TableCell(_points(each), f"better for {each.against.worse}, worse for {each.against.better}"),
                TableCell(figure(each.in_time_share, percent=True)),
                TableCell(figure(each.without_gnss_min_per_h * fleet_hours)),
            ]
            lines.append(TableRow("best" if each.defence in ranking.best else "", each.defence, cells))
        headings = ["", "defence", "threshold, and its rate", "false alarms a day", "out of lane"]
        headings += [f"less {ranking.best[0]} (points of %)", "alarm before the line", "minutes without GNSS a day"]
        caption = (
            f"Of a fleet that drives {fleet_hours:g} hours a day, at the rates counted in {ranking.vehicle_hours:.1f}"
            f" vehicle-hours; {ranking.vehicles} attacked vehicles. The difference is over pairs of the same vehicle,"
            " with bounds that hold for all defences together."
        )
        made.append(ReportTable(group_name(ranking.scenario, ranking.profile), headings, lines, caption))
    return made


def advice(run: Results, ranked: Sequence[Ranking], fleet_hours: float) -> list[Advice]:
    """Return which detector to take, at which threshold; it may be that there is no difference, or that none helps."""
    return [
        Advice(group_name(ranking.scenario, ranking.profile), _sentences(run, ranking, fleet_hours))
        for ranking in ranked
    ]


def _sentences(run: Results, ranking: Ranking, fleet_hours: float) -> list[str]:
    if not ranking.best:
        return [f"There is nothing to decide on: {ranking.note}."]
    if not ranking.helps:
        return [
            f"No difference: {ranking.vehicles} vehicles do not tell any defence from none. More vehicles, or more"
            " seeds, may; until then there is no reason to take one."
        ]
    rates = _rates(run, ranking)
    said = []
    if ranking.winner:
        said.append(f"Take {ranking.winner}: it leaves fewer vehicles out of their lane than every other defence here.")
    else:
        said.append(
            f"No difference between {named_together(ranking.best, _MANY)} in vehicles out of their lane, of"
            f" {ranking.vehicles} that were attacked. Take the one that costs least, which these figures may not tell"
            " apart either:"
        )
    costs = sorted(ranking.best, key=lambda name: (rates[name][0], ranking.standings[name].without_gnss_min_per_h))
    said += [_cost(name, rates[name], ranking.standings[name], fleet_hours) for name in costs]
    return said + _other_rates(ranking, rates, fleet_hours)


def _cost(name: str, rate: tuple[float, float, float], standing: Standing, fleet_hours: float) -> str:
    mean, low, high = (figure(value * fleet_hours) for value in rate)
    minutes = figure(standing.without_gnss_min_per_h * fleet_hours)
    if _never_alarms(name):
        return f"{name}: no detector, so no false alarms; {minutes} minutes without GNSS a day."
    return f"{name}: {mean} false alarms a day ({low} – {high}), {minutes} minutes without GNSS."


def _other_rates(ranking: Ranking, rates: dict[str, tuple[float, float, float]], fleet_hours: float) -> list[str]:
    """Say of the further rates of the best whether they keep more vehicles in their lane, and at which price."""
    said = []
    for name, each in ranking.standings.items():
        if "@" not in name or without_rate(name) not in ranking.best or not _can_choose(name):
            continue
        more = (rates[name][0] - rates[without_rate(name)][0]) * fleet_hours
        gain = "fewer out of their lane" if each.against.apart and each.against.mean < 0.0 else "no difference"
        if each.against.apart and each.against.mean > 0.0:
            gain = f"more out of their lane than with {ranking.best[0]}"
        said.append(f"{name}: {gain}, for {figure(more)} more false alarms a day.")
    return said


def _rates(run: Results, ranking: Ranking) -> dict[str, tuple[float, float, float]]:
    """Return the false alarms in a vehicle-hour of each defence's detector, with bounds; none where it has no alarm."""
    name = "false_alarms_per_vehicle_hour"
    rows = of_group(run.detection, ranking.scenario, ranking.profile).drop_duplicates("detector").to_dict("records")
    known = {str(row["detector"]): tuple(float(row[name + end]) for end in ("", "_lo", "_hi")) for row in rows}
    found = {}
    for defence in ranking.standings:
        none = _never_alarms(defence)
        mean, low, high = (0.0, 0.0, 0.0) if none else known.get(defence.partition("+")[0], (0.0, 0.0, 0.0))
        found[defence] = (mean, mean if np.isnan(low) else low, mean if np.isnan(high) else high)
    return found


def _points(each: Standing) -> str:
    difference = each.against
    text = figure(100.0 * difference.mean)
    return (
        text
        if difference.low == difference.high
        else f"{text} ({figure(100.0 * difference.low)} – {figure(100.0 * difference.high)})"
    )


def _never_alarms(defence: str) -> bool:
    return defence.startswith("never+")


def _can_choose(defence: str) -> bool:
    return defence != UNDEFENDED and not defence.startswith("told")
