"""Chooses the vehicles that a report traces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.outcomes.ranking import Ranking
from gpsec.report.figure_data import group_name
from gpsec.running.results import Results
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED


@dataclass(frozen=True)
class Story:
    """One vehicle under one attack.

    Attributes:
        scenario, profile, vehicle_id, attack: of the event; `attack` is ``none`` for a vehicle that has none.
        why: it was chosen.
        start_s, end_s: of the attack; of the journey where there is none.
        events: its rows of `events.csv`, one for each defence; none without an attack.

    """

    scenario: str
    profile: str
    vehicle_id: str
    attack: str
    why: str
    start_s: float
    end_s: float
    events: pd.DataFrame

    @property
    def group(self) -> str:
        """Scenario and profile."""
        return group_name(self.scenario, self.profile)

    @property
    def label(self) -> str:
        """Title in the report's selector."""
        what = "no attack" if self.attack == "none" else self.attack
        return f"{self.why + ': ' if self.why else ''}{self.vehicle_id}, {what}"


# Scenario -> (vehicle, attack) whose steps are known; scenarios in which those of all are known are not in it.
Known = Mapping[str, frozenset[tuple[str, str]]]


def choose_stories(run: Results, ranked: Sequence[Ranking] | None = None, known: Known | None = None) -> list[Story]:
    """Return three vehicles of each scenario and profile: the worst, the median and the first missed one.

    All are judged by the largest error across the lane, under the first of the best defences of `ranked`, the rankings
    of the run; under none where nothing is judged. Where steps are not `known` of one of them, the nearest of those of
    which they are is taken, and its reason says so.
    """
    rankings = run.rankings() if ranked is None else ranked
    best = {(each.scenario, each.profile): each.best[0] for each in rankings if each.best}
    stories = []
    for keys, all_rows in run.events.groupby(["scenario", "profile"], sort=False, observed=True):
        scenario, profile = map(str, keys)
        defence = best.get((scenario, profile), UNDEFENDED)
        rows = all_rows[all_rows["defence"] == defence]
        by_error = rows.dropna(subset=["max_cross_track_m"]).sort_values(["max_cross_track_m", "vehicle_id", "attack"])
        picks = {"worst": (by_error, len(by_error) - 1), "median": (by_error, (len(by_error) - 1) // 2)}
        if defence.partition("+")[0] not in BOUNDS:
            picks["first missed"] = rows[~rows["detected"]].sort_values(["start_s", "vehicle_id"]), 0
        for why, (ordered, wanted) in picks.items():
            found = _nearest(ordered, wanted, None if known is None else known.get(scenario))
            if found is not None:
                rank = "" if found == wanted else f" of those kept (rank {found + 1} of {len(ordered)})"
                stories.append(_story(run, ordered.iloc[found].to_dict(), why + rank))
    return stories


def _nearest(ordered: pd.DataFrame, wanted: int, known: frozenset[tuple[str, str]] | None) -> int | None:
    """Return the place next to the `wanted` one whose steps are known; None where there is none."""
    names = zip(ordered["vehicle_id"].astype(str), ordered["attack"].astype(str), strict=True)
    places = [place for place, name in enumerate(names) if known is None or name in known]
    return min(places, key=lambda place: abs(place - wanted), default=None)


def worst_stories(run: Results, scenario: str | None = None, most: int = 5) -> list[Story]:
    """Return the vehicles with the largest errors across the lane, each once: under the first of the best defences.

    Raises:
        GpsecError: the run has no such scenario.
    """
    if scenario is not None:
        run.manifest(scenario)
    best = {(each.scenario, each.profile): each.best[0] for each in run.rankings() if each.best}
    events = run.events if scenario is None else run.events[run.events["scenario"] == scenario]
    keys = zip(events["scenario"].astype(str), events["profile"].astype(str), strict=True)
    chosen = events[events["defence"].astype(str).to_numpy() == [best.get(key, UNDEFENDED) for key in keys]]
    ordered = chosen.dropna(subset=["max_cross_track_m"]).sort_values("max_cross_track_m", ascending=False)
    worst = ordered.drop_duplicates(["scenario", "vehicle_id"]).head(most)
    return [_story(run, row, "worst") for row in worst.to_dict("records")]


def story_of(run: Results, vehicle_id: str, scenario: str | None = None, attack: str | None = None) -> Story:
    """Return the story of one vehicle: under `attack`, or else the first that it was under, or none.

    Raises:
        GpsecError: there is no such vehicle, or it was not attacked in this way.
    """
    mine = run.vehicles[run.vehicles["vehicle_id"] == vehicle_id]
    if scenario is not None:
        run.manifest(scenario)
        mine = mine[mine["scenario"] == scenario]
    if mine.empty:
        close = get_close_matches(vehicle_id, run.vehicles["vehicle_id"].cat.categories, n=1)
        hint = f"did you mean '{shown(close[0])}'?" if close else "their ids are in vehicles.csv"
        raise GpsecError(f"{run.folder}: no vehicle '{shown(vehicle_id)}' in this run; {hint}")
    scenarios = list(dict.fromkeys(mine["scenario"]))
    if len(scenarios) > 1:
        raise GpsecError(
            f"{run.folder}: vehicle '{shown(vehicle_id)}' is in {', '.join(scenarios)}; say which with --scenario"
        )
    attacks = [name for name in dict.fromkeys(mine["attack"]) if name != "none"]
    if attack is not None and attack not in {*attacks, "none"}:
        raise GpsecError(
            f"{run.folder}: vehicle '{shown(vehicle_id)}' was not under '{shown(attack)}': {nearest(attack, attacks)}"
        )
    chosen = attack or next(iter(attacks), "none")
    events = run.events
    rows = events[(events["scenario"] == scenarios[0]) & (events["vehicle_id"] == vehicle_id)]
    rows = rows[rows["attack"] == chosen]
    if not rows.empty:
        return _story(run, rows.iloc[0].to_dict(), "")
    life = mine[mine["attack"] == "none"].iloc[0]
    end_s = life["arrive_s"] if pd.notna(life["arrive_s"]) else life["depart_s"] + life["vehicle_seconds"]
    return Story(scenarios[0], life["profile"], vehicle_id, "none", "", life["depart_s"], float(end_s), rows)


def _story(run: Results, row: dict[Any, Any], why: str) -> Story:
    events = run.events
    mine = events[
        (events["scenario"] == row["scenario"])
        & (events["vehicle_id"] == row["vehicle_id"])
        & (events["attack"] == row["attack"])
    ]
    return Story(
        row["scenario"],
        row["profile"],
        row["vehicle_id"],
        row["attack"],
        why,
        float(row["start_s"]),
        float(row["end_s"]),
        mine,
    )
