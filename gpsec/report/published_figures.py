"""The figures of `gpsec figure`: from runs to vector graphics, with the numbers that the caption needs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.ranking import Ranking, of_group
from gpsec.report.deciding import FLEET_HOURS
from gpsec.report.gathering import Gathered
from gpsec.report.matched_table import one_point_each
from gpsec.report.press import LineLooks, Width, printed
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED
from gpsec.types.points import without_rate

# Where none has its place on a logarithmic axis of false alarms a day.
_NONE = 0.1
_FEWEST_SHARE = 1e-5
# What is missed at more false positives is of no use to anybody, and would take up most of a logarithmic axis.
_MOST_RATE = 0.1


@dataclass(frozen=True)
class Picture:
    """What is drawn: of which scenario, profile and attack, how wide, into which file."""

    scenario: str
    profile: str
    attack: str
    width: Width
    path: Path


def draw_figure(name: str, found: Gathered, wanted: Picture) -> str:
    """Draw one of `FIGURES_FOR_PAPERS`; return its caption.

    Raises:
        GpsecError: there is none of that name, or the runs have nothing to show in it.
    """
    if name not in FIGURES_FOR_PAPERS:
        raise GpsecError(f"NAME: unknown figure '{shown(name)}': {nearest(name, FIGURES_FOR_PAPERS)}")
    return FIGURES_FOR_PAPERS[name](found, wanted)


def _rows(found: Gathered, table: str, wanted: Picture, *, attack: bool = True) -> pd.DataFrame:
    """Return the rows of what is wanted.

    Raises:
        GpsecError: there is none.
    """
    rows = of_group(found.tables[table], wanted.scenario, wanted.profile)
    if attack:
        rows = rows[rows["attack"] == wanted.attack]
    if rows.empty:
        raise GpsecError(f"no row of {table}.csv is of '{shown(wanted.scenario)}', {wanted.profile}, {wanted.attack}")
    return rows


def _caption(found: Gathered, wanted: Picture, what: str, n: int) -> str:
    """Return the caption of a figure of one attack, without intervals."""
    over = f"{found.over(base_name(wanted.scenario))}; {found.made_by}"
    return f"{what}, {wanted.scenario}, profile {wanted.profile}, under {wanted.attack}; n = {n}; {over}."


def _judged_caption(ranking: Ranking, what: str, over: str) -> str:
    """Return the caption of a figure of all attacks that are judged together."""
    return f"{what}, {ranking.scenario}, profile {ranking.profile}; n = {ranking.vehicles} vehicles; {over}."


def _ranking(found: Gathered, wanted: Picture) -> Ranking:
    for ranking in found.ranked:
        if (ranking.scenario, ranking.profile) == (wanted.scenario, wanted.profile) and ranking.best:
            return ranking
    raise GpsecError(f"nothing is judged in '{shown(wanted.scenario)}', {wanted.profile}, so there is no such figure")


def _outcomes(found: Gathered, wanted: Picture) -> str:
    """Draw the share out of lane of each defence, over all attacks that are judged together, with intervals."""
    ranking = _ranking(found, wanted)
    order = sorted(ranking.standings.values(), key=lambda each: each.share)
    place = np.arange(len(order))
    share, low, high = (np.array([getattr(each, key) for each in order]) for key in ("share", "low", "high"))
    with printed(wanted.path, wanted.width) as axes:
        one = axes[0, 0]
        colours = ["#0072B2" if each.defence in ranking.best else "#999999" for each in order]
        one.barh(place, share, color=colours, height=0.65)
        one.errorbar(
            share,
            place,
            xerr=[np.maximum(share - low, 0), np.maximum(high - share, 0)],
            fmt="none",
            color="black",
            lw=0.8,
        )
        one.set_yticks(place, [each.defence for each in order])
        one.grid(visible=False, axis="y")
        one.set_xlabel("share of attacks out of lane, mean of vehicles")
        one.set_xlim(left=0.0)
    what = "Share of a vehicle's attacks that put it out of its lane; blue: not told apart from the best"
    return _judged_caption(ranking, what, found.caption(base_name(ranking.scenario)))


def _decision(found: Gathered, wanted: Picture) -> str:
    """Draw false alarms a day of a fleet against the share out of lane, a line for each defence."""
    ranking = _ranking(found, wanted)
    names = [name for name in ranking.standings if name != UNDEFENDED and not name.startswith("told")]
    look = LineLooks(list(dict.fromkeys(map(without_rate, names))))
    with printed(wanted.path, wanted.width) as axes:
        one = axes[0, 0]
        for defence in dict.fromkeys(map(without_rate, names)):
            points = [ranking.standings[name] for name in names if without_rate(name) == defence]
            points.sort(key=lambda each: each.false_alarms_per_h)
            x = [max(each.false_alarms_per_h * FLEET_HOURS, _NONE) for each in points]
            one.plot(x, [each.share for each in points], label=defence, **look.of(defence))
        one.set_xscale("log")
        one.set_xlabel(f"false alarms a day, of a fleet that drives {FLEET_HOURS:g} h")
        one.set_ylabel("share out of lane")
        one.set_ylim(bottom=0.0)
    over = f"{found.over(base_name(ranking.scenario))}; {found.made_by}"
    return _judged_caption(ranking, "What protection costs", over)


def _roc(found: Gathered, wanted: Picture) -> str:
    """Draw what is missed against false positives, both logarithmic; with several seeds, a line for each."""
    rows = _rows(found, "curves", wanted)
    names = one_point_each([name for name in rows["detector"].unique() if name not in BOUNDS])
    look = LineLooks(names)
    used = rows[rows["detector"].isin(names) & (rows["false_positive_rate"] <= _MOST_RATE)]
    with printed(wanted.path, wanted.width) as axes:
        one = axes[0, 0]
        for (_, detector), points in rows.groupby(["scenario", "detector"], sort=False):
            if detector in names:
                x = np.maximum(points["false_positive_rate"], _FEWEST_SHARE)
                missed = np.maximum(1.0 - points["recall"], _FEWEST_SHARE)
                one.plot(
                    x, missed, label=str(detector), drawstyle="steps-post", **(look.of(str(detector)) | {"marker": ""})
                )
        one.set_xscale("log")
        one.set_yscale("log")
        one.set_xlim(_FEWEST_SHARE, 1.0)
        one.set_ylim(max(0.5 * (1.0 - used["recall"].max()), _FEWEST_SHARE), 1.0)
        one.set_xlabel("false-positive rate")
        one.set_ylabel("missed share of the samples")
    events = int(_rows(found, "detection", wanted)["n_events"].max())
    return _caption(found, wanted, "What detectors miss against false positives, for every threshold", events)


def _delay(found: Gathered, wanted: Picture) -> str:
    """Draw the distribution of detection delays; where it ends below 1 the rest was not seen."""
    events = _rows(found, "events", wanted).drop_duplicates(["scenario", "vehicle_id", "detector"])
    names = [name for name in events["detector"].unique() if name not in BOUNDS]
    look = LineLooks(names)
    with printed(wanted.path, wanted.width) as axes:
        one = axes[0, 0]
        for name in names:
            delay = events.loc[events["detector"] == name, "detection_delay_s"]
            seen = np.sort(delay.dropna())
            share = np.arange(1, len(seen) + 1) / len(delay)
            one.plot(
                [0.0, *seen], [0.0, *share], label=name, drawstyle="steps-post", **(look.of(name) | {"marker": ""})
            )
        one.set_xlabel("time since the attack began (s)")
        one.set_ylabel("share seen by then")
        one.set_ylim(0.0, 1.02)
        one.set_xlim(left=0.0)
    attacked = len(events.drop_duplicates(["scenario", "vehicle_id"]))
    return _caption(found, wanted, "How soon attacks are seen", attacked)


def _error(found: Gathered, wanted: Picture) -> str:
    """Draw the median error across the lane of each defence over the time under attack; a line for each seed."""
    rows = _rows(found, "error_bands", wanted)
    names = list(dict.fromkeys(rows["defence"]))
    look = LineLooks(names, UNDEFENDED)
    with printed(wanted.path, wanted.width) as axes:
        one = axes[0, 0]
        for (_, defence), points in rows.groupby(["scenario", "defence"], sort=False):
            style = look.of(str(defence)) | {"markevery": max(len(points) // 6, 1)}
            one.plot(points["time_s"], points["cross_track_median_m"], label=str(defence), **style)
        one.set_xlabel("time since the attack began (s)")
        one.set_ylabel("median error across (m)")
        one.set_yscale("log")
    return _caption(found, wanted, "Error across the lane, of those still under attack", int(rows["n_vehicles"].max()))


FIGURES_FOR_PAPERS: Mapping[str, Callable[[Gathered, Picture], str]] = {
    "outcomes": _outcomes,
    "decision": _decision,
    "roc": _roc,
    "delay": _delay,
    "error": _error,
}
"""What `gpsec figure` draws, by name."""


def first_of(found: Gathered, options: Sequence[str | None]) -> tuple[str, str, str]:
    """Return scenario, profile and attack as far as they are given, and the first that the runs have of the others.

    Raises:
        GpsecError: one that is given is in none of the runs.
    """
    safety = found.tables["safety"]
    chosen = []
    for column, given in zip(("scenario", "profile", "attack"), options, strict=True):
        known = [str(name) for name in safety[column].unique() if name != "none"]
        if given is not None and given not in known:
            raise GpsecError(f"--{column}: '{shown(given)}' is in none of the runs: {nearest(given, known)}")
        name = given if given is not None else known[0]
        chosen.append(name)
        safety = safety[(safety[column] == name) | (column == "attack")]
    return chosen[0], chosen[1], chosen[2]
