"""The verdict on a run: in sentences, as an overview of all scenarios, and attack by attack."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from gpsec.outcomes.brief import extent
from gpsec.outcomes.concentration import gatherings
from gpsec.outcomes.paired import named_together
from gpsec.outcomes.ranking import Ranking, of_group
from gpsec.report.figure_data import group_name
from gpsec.report.figures import defences_of
from gpsec.report.formatting import EMPTY, Record, figure, interval
from gpsec.report.tables import TableCell
from gpsec.running.results import Results
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED

# From this share on, it is all of them to the percent.
_ALL = 0.995
_MANY = 12


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
        overview: its row in the overview of all scenarios.
        defences: columns.
        best: those of them that are named as the best.
        false_alarms: of each defence's detector, in words; vehicle_hours: that they were counted in.
        rows: attack -> a cell for each defence; first those that are judged together.
        apart: attacks that stand apart.

    """

    group: str
    sentences: list[str]
    overview: list[TableCell]
    defences: list[str]
    best: tuple[str, ...]
    false_alarms: list[str]
    vehicle_hours: float
    rows: dict[str, list[VerdictCell]]
    apart: tuple[str, ...] = ()


OVERVIEW = (
    "scenario",
    "vehicles",
    "out of lane undefended",
    "with the best",
    "best defences",
    "alarm before the line",
    "by (s)",
    "false alarms an hour",
    "min without GNSS an hour",
)


def verdicts(run: Results, ranked: Sequence[Ranking]) -> list[Verdict]:
    """Return the verdict on each scenario and profile that `ranked`, the rankings of `run`, has vehicles for."""
    order = defences_of(run)
    found = []
    for ranking in ranked:
        safety = of_group(run.safety, ranking.scenario, ranking.profile)
        if not (safety["n_vehicles"] > 0).any():
            continue
        rates = of_group(run.detection, ranking.scenario, ranking.profile).to_dict("records")
        once = {str(row["detector"]): row for row in rates}
        here = set(safety["defence"])
        defences = [name for name in order if name in here]
        noted = safety["note"].notna().any()
        rows = {} if noted else _rows(ranking, safety, rates, defences)
        found.append(
            Verdict(
                group_name(ranking.scenario, ranking.profile),
                [
                    *(one.sentence() for one in gatherings(run.tables, ranking)),
                    *_sentences(ranking),
                    *_apart(ranking, rows, defences),
                ],
                _overview(ranking),
                defences if rows else [],
                ranking.best,
                [_false_alarms(once, name.partition("+")[0]) for name in defences],
                max(float(row["vehicle_hours"]) for row in rates),
                rows,
                tuple(ranking.apart),
            )
        )
    return found


def _rows(
    ranking: Ranking, safety: pd.DataFrame, rates: Sequence[Record], defences: Sequence[str]
) -> dict[str, list[VerdictCell]]:
    seen = {(row["attack"], row["detector"]): row for row in rates}
    judged = safety[(safety["n_vehicles"] > 0) & (safety["attack"] != "none")].to_dict("records")
    attacked = {(row["attack"], row["defence"]): row for row in judged}
    attacks = sorted(dict.fromkeys(str(row["attack"]) for row in judged), key=lambda name: name in ranking.apart)
    return {attack: [_cell(attacked[attack, name], seen, attack, name) for name in defences] for attack in attacks}


def _cell(safety: Record, seen: Mapping[tuple[str, str], Record], attack: str, defence: str) -> VerdictCell:
    detector = defence.partition("+")[0]
    words = ""
    if detector not in BOUNDS and (attack, detector) in seen:
        row = seen[attack, detector]
        share = row["detected_share"]
        # Over several seeds there is a mean only.
        usual_s: float = row["delay_mean_s"] if pd.isna(row["delay_median_s"]) else row["delay_median_s"]
        delay: str = "" if pd.isna(usual_s) else f"seen after {usual_s:.1f}\N{NO-BREAK SPACE}s"
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


def _percent(share: float) -> str:
    return figure(share, percent=True)


def _sentences(ranking: Ranking) -> list[str]:
    """Say what attacks do undefended, which defences are best and which are not."""
    plain = ranking.undefended
    if plain is None or not ranking.best:
        return [f"Nothing is judged here: {ranking.note}."]
    attacks = f"{len(ranking.attacks)} attack{'s' if len(ranking.attacks) > 1 else ''} that act across the road"
    said = [
        f"Undefended, an attack would have put a vehicle out of its lane in {_percent(plain.share)} of all cases"
        f" ({_percent(plain.low)} – {_percent(plain.high)}; {ranking.vehicles} vehicles, each counted once: the mean of"
        f" its share of the {attacks})."
    ]
    best = [ranking.standings[name] for name in ranking.best]
    left = extent([each.share for each in best], _percent)
    alarms = extent([each.false_alarms_per_h for each in best], figure)
    cost = f"{alarms} false alarms per vehicle-hour, counted in {figure(ranking.vehicle_hours)} of them"
    if ranking.winner:
        said.append(f"With {ranking.winner} it is {left}, better than with every other defence here; {cost}.")
    elif not ranking.helps:
        said.append(
            "No defence here can be told apart from none: with"
            f" {named_together([name for name in ranking.best if name != UNDEFENDED], _MANY)} it is {left}."
        )
    else:
        said.append(
            f"There is no difference between {named_together(ranking.best, _MANY)}, as far as these vehicles tell: with"
            f" them it is {left}; {cost}."
        )
    return said + _worse(ranking)


def _worse(ranking: Ranking) -> list[str]:
    """Name the defences that are worse than the best beyond chance, with the interval of the difference."""
    worse = [
        each
        for name, each in ranking.standings.items()
        if each.against.apart and each.against.mean > 0.0 and name != UNDEFENDED and not name.startswith("told")
    ]
    if not worse:
        return []
    named = "; ".join(
        f"{each.defence} by {100.0 * each.against.mean:.1f} ({100.0 * each.against.low:.1f} –"
        f" {100.0 * each.against.high:.1f})"
        for each in sorted(worse, key=lambda each: each.against.mean)
    )
    return [f"Worse than {ranking.best[0]}, in points of per cent over pairs of the same vehicle: {named}."]


def _apart(ranking: Ranking, rows: Mapping[str, Sequence[VerdictCell]], defences: Sequence[str]) -> list[str]:
    """Say of the attacks that stand apart what they do, undefended and with each defence."""
    said = []
    for attack, why in ranking.apart.items():
        if attack not in rows or UNDEFENDED not in defences:
            continue
        cells = dict(zip(defences, rows[attack], strict=True))
        plain = cells[UNDEFENDED]
        counts = {name: cells[name].count for name in defences if "@" not in name and not name.startswith("told")}
        fewest, most = min(counts.values()), max(n for name, n in counts.items() if name != UNDEFENDED)
        with_fewest = named_together(
            [name for name, count in counts.items() if count == fewest and name != UNDEFENDED], _MANY
        )
        reason = (
            "acts along the road, which no comparison of lanes can see"
            if why.startswith("along")
            else "leaves nothing to compare, so that what counts is how the vehicle goes on without fixes"
        )
        favour = f", fewest with {with_fewest}" if with_fewest and fewest < most else ""
        did = f"Undefended {plain.count} of {plain.of} vehicles would have left their lane"
        said.append(f"Apart: {attack} {reason}. {did}; with defences {fewest} to {most}{favour}.")
    return said


def _overview(ranking: Ranking) -> list[TableCell]:
    name = group_name(ranking.scenario, ranking.profile)
    plain = ranking.undefended
    if plain is None or not ranking.best:
        return [
            TableCell(name),
            *[TableCell(EMPTY)] * 3,
            TableCell("not judged", ranking.note),
            *[TableCell(EMPTY)] * 4,
        ]
    best = [ranking.standings[each] for each in ranking.best]
    seen = [each for each in best if each.in_time_share > 0.0]
    small = "better than every other" if ranking.winner else "no difference between them"
    if not ranking.helps:
        small = "none can be told apart from no defence"
    return [
        TableCell(name),
        TableCell(str(ranking.vehicles)),
        TableCell(_percent(plain.share), f"{_percent(plain.low)} – {_percent(plain.high)}"),
        TableCell(
            extent([each.share for each in best], _percent), f"at most {_percent(max(each.high for each in best))}"
        ),
        TableCell(named_together(ranking.best, _MANY), small),
        TableCell(extent([each.in_time_share for each in seen], _percent)),
        TableCell(extent([each.before_line_s for each in seen], figure)),
        TableCell(
            extent([each.false_alarms_per_h for each in best], figure), f"in {figure(ranking.vehicle_hours)} hours"
        ),
        TableCell(extent([each.without_gnss_min_per_h for each in best], figure)),
    ]
