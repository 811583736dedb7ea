"""Writes the report of a run, and the page of a single vehicle."""

import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

import pandas as pd

from gpsec.core.version import __version__
from gpsec.outcomes.naming import base_name
from gpsec.report.about import described
from gpsec.report.deciding import FLEET_HOURS, advice, decision_figure, decision_tables
from gpsec.report.figure_data import group_name
from gpsec.report.figures import all_figures
from gpsec.report.impact import impact_tables
from gpsec.report.lanes import association_tables
from gpsec.report.map import map_figure
from gpsec.report.page import render, write_page
from gpsec.report.stories import Known, Story, choose_stories
from gpsec.report.tables import detection_tables, localization_tables, safety_tables
from gpsec.report.terminal import facts
from gpsec.report.traces import trace_figures
from gpsec.report.verdict import OVERVIEW, verdicts
from gpsec.report.worlds_page import write_worlds
from gpsec.report.worst_streets import worst_streets
from gpsec.running.results import Results
from gpsec.types.constants import REPORT

Steps = Mapping[str, pd.DataFrame | None]


def write_report(
    run: Results, steps: Steps | None = None, path: Path | None = None, fleet_hours: float = FLEET_HOURS
) -> Path:
    """Write the report of a run into its folder, or to `path`, and return where it is.

    `steps` holds the steps of the chosen vehicles of each scenario; without it, those that the run has kept or logged
    are taken. False alarms a day are those of a fleet that drives `fleet_hours` in one. A run in closed loop has a page
    of its own, which needs neither.
    """
    target = path or run.folder / REPORT
    if run.worlds:
        return write_worlds(run, target)
    over = run.over_seeds()
    looked_at = [run] if over is None else [over, run]
    ranked = [each.rankings() for each in looked_at]
    stories = choose_stories(run, ranked[-1], traced(run) if steps is None else None)
    known = known_steps(run, stories) if steps is None else steps
    judged = [ranking for each in ranked for ranking in each]
    figures = all_figures(run, over) | {"map": map_figure(run)} | trace_figures(run, stories, known)
    figures["decision"] = decision_figure(looked_at[0], judged, fleet_hours)
    groups = list(
        dict.fromkeys(
            group_name(*pair)
            for each in looked_at
            for pair in zip(each.detection["scenario"], each.detection["profile"], strict=True)
        )
    )
    attacks = [name for name in run.safety["attack"].cat.categories if name != "none"]
    page = render(
        "report.html",
        {
            "figures": {key: figure.plain() for key, figure in figures.items()},
            "groups": groups,
            "attacks": attacks,
            "pooled": [] if over is None else [group_name(each.scenario, each.profile) for each in ranked[0]],
        },
        title=", ".join(_titles(run, over)),
        unfinished=run.unfinished,
        changed=run.changed,
        verdicts=[verdict for each, found in zip(looked_at, ranked, strict=True) for verdict in verdicts(each, found)],
        overview=OVERVIEW,
        advice=[
            said for each, found in zip(looked_at, ranked, strict=True) for said in advice(each, found, fleet_hours)
        ],
        streets=worst_streets(run, ranked[-1]),
        decisions=[
            table
            for each, found in zip(looked_at, ranked, strict=True)
            for table in decision_tables(each, found, fleet_hours)
        ],
        runs=[described(stated) for stated in run.scenarios],
        figures=figures,
        groups=groups,
        attacks=attacks,
        tables={
            name: [table for each in looked_at for table in make(each)]
            for name, make in (
                ("detection", detection_tables),
                ("localization", localization_tables),
                ("safety", safety_tables),
            )
        }
        | {"association": association_tables(run), "impact": impact_tables(run)},
        version=__version__,
    )
    write_page(target, page)
    return target


def _titles(run: Results, over: Results | None) -> list[str]:
    """Return the scenarios of a run, each once, however many seeds it has."""
    names = [str(stated["scenario"]) for stated in run.scenarios]
    several = set() if over is None else {stated["scenario"] for stated in over.scenarios}
    return list(dict.fromkeys(base_name(name) if base_name(name) in several else name for name in names))


def trace_page(vehicle_id: str) -> str:
    """Return the file name of the page of one vehicle; two ids never have the same."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", vehicle_id)[:100]
    mark = "" if plain == vehicle_id else f"-{sha256(vehicle_id.encode()).hexdigest()[:8]}"
    return f"trace-{plain}{mark}.html"


def write_trace(run: Results, story: Story, steps: Steps, path: Path) -> Path:
    """Write the page of one vehicle to `path`, and return it."""
    figures = trace_figures(run, [story], steps)
    page = render(
        "trace.html",
        {
            "figures": {key: figure.plain() for key, figure in figures.items()},
            "groups": [story.group],
            "attacks": [],
        },
        title=f"{story.vehicle_id}, {story.group}",
        story=story,
        facts=facts(run, story),
        figures=figures,
        version=__version__,
    )
    write_page(path, page)
    return path


def traced(run: Results) -> Known:
    """Return of which vehicles under which attacks the run has kept traces, where it has not logged all steps."""
    traces = {stated["scenario"]: run.traces(stated["scenario"]) for stated in run.scenarios}
    return {
        name: frozenset(zip(rows["vehicle_id"], rows["plan"], strict=True))
        - {(who, "none") for who in rows["vehicle_id"]}
        for name, rows in traces.items()
        if rows is not None
    }


def known_steps(run: Results, stories: list[Story]) -> dict[str, pd.DataFrame | None]:
    """Return the steps of the vehicles of `stories` that the run has kept or logged, None where it has neither."""
    found = {}
    for name, vehicles in _vehicles_of(stories).items():
        traces = run.traces(name, vehicles)
        found[name] = run.steps(name, vehicles) if traces is None else traces
    return found


def logged_steps(run: Results, stories: list[Story]) -> dict[str, pd.DataFrame | None]:
    """Return the logged steps of the vehicles of `stories`, None for scenarios without a log."""
    return {name: run.steps(name, vehicles) for name, vehicles in _vehicles_of(stories).items()}


def _vehicles_of(stories: list[Story]) -> dict[str, list[str]]:
    wanted: dict[str, list[str]] = {}
    for story in stories:
        wanted.setdefault(story.scenario, []).append(story.vehicle_id)
    return wanted
