"""Writes the report of a run, and the page of a single vehicle."""

import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.version import __version__
from gpsec.report.deciding import FLEET_HOURS, advice, decision_figure, decision_tables
from gpsec.report.figure_data import group_name
from gpsec.report.figures import all_figures
from gpsec.report.formatting import seconds
from gpsec.report.lanes import association_tables
from gpsec.report.map import map_figure
from gpsec.report.page import render, write_page
from gpsec.report.stories import Story, choose_stories
from gpsec.report.tables import detection_tables, localization_tables, safety_tables
from gpsec.report.terminal import facts
from gpsec.report.traces import trace_figures
from gpsec.report.verdict import OVERVIEW, verdicts
from gpsec.running.results import Results
from gpsec.scenario.sections import WorldSection
from gpsec.types.constants import REPORT

# So many vehicles are named, where more saw pictures.
_NAMED = 10
Steps = Mapping[str, pd.DataFrame | None]


def write_report(
    run: Results, steps: Steps | None = None, path: Path | None = None, fleet_hours: float = FLEET_HOURS
) -> Path:
    """Write the report of a run into its folder, or to `path`, and return where it is.

    `steps` holds the steps of the chosen vehicles of each scenario; without it, those that the run has logged are
    taken. False alarms a day are those of a fleet that drives `fleet_hours` in one.
    """
    over = run.over_seeds()
    looked_at = [run] if over is None else [over, run]
    ranked = [each.rankings() for each in looked_at]
    stories = choose_stories(run, ranked[-1])
    target = path or run.folder / REPORT
    known = logged_steps(run, stories) if steps is None else steps
    judged = [ranking for each in ranked for ranking in each]
    figures = all_figures(run) | {"map": map_figure(run)} | trace_figures(run, stories, known)
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
        {"figures": {key: figure.plain() for key, figure in figures.items()}, "groups": groups, "attacks": attacks},
        title=", ".join(stated["scenario"] for stated in run.scenarios),
        unfinished=run.unfinished,
        changed=run.changed,
        verdicts=[verdict for each, found in zip(looked_at, ranked, strict=True) for verdict in verdicts(each, found)],
        overview=OVERVIEW,
        advice=[
            said for each, found in zip(looked_at, ranked, strict=True) for said in advice(each, found, fleet_hours)
        ],
        decisions=[
            table
            for each, found in zip(looked_at, ranked, strict=True)
            for table in decision_tables(each, found, fleet_hours)
        ],
        runs=[_described(stated) for stated in run.scenarios],
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
        | {"association": association_tables(run)},
        version=__version__,
    )
    write_page(target, page)
    return target


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


def logged_steps(run: Results, stories: list[Story]) -> dict[str, pd.DataFrame | None]:
    """Return the logged steps of the vehicles of `stories`, None for scenarios without a log."""
    wanted: dict[str, list[str]] = {}
    for story in stories:
        wanted.setdefault(story.scenario, []).append(story.vehicle_id)
    return {scenario: run.steps(scenario, vehicles) for scenario, vehicles in wanted.items()}


def _described(stated: dict[str, Any]) -> dict[str, Any]:
    """Return the facts that the page lists of a scenario: its settings, plans, notes and cost."""
    given = stated["configuration"]
    steps = stated["steps"] * stated["step_s"]
    plans = [
        {
            "name": plan["name"],
            "attack": plan["attack"],
            "where": "in its zone" if "shape_m" in plan else f"{plan['share']:.0%} of the vehicles",
            "parameters": ", ".join(f"{name} {_value(value)}" for name, value in plan["parameters"].items()),
        }
        for plan in stated["plans"]
    ]
    facts = {
        "traffic": f"{given['sumocfg']}, {seconds(steps)} in steps of {stated['step_s']:g} s, seed {stated['seed']}",
        "fleet": f"{stated['vehicles']} vehicles with sensors ({given['fleet']['equipped_share']:.0%} of those whose"
        f" type does not say), {stated['vehicle_steps']:,} vehicle-steps, at most {stated['peak_vehicles']} at a time",
        "sensor profiles": ", ".join(stated["profiles"]),
        "what filters and detectors do not know": _unknown(given.get("world", {})),
        **_pictured(stated),
        "lane association": given["fleet"]["association"],
        "scored and attacked": f"after {given['fleet']['settle_s']:g} s on the road",
        "false-alarm rates of the thresholds": ", ".join(given["detection"]["rates"]),
        "GNSS is used again": f"{given['localization']['hold_s']:g} s after the last alarm, once fixes have agreed for"
        f" {given['localization']['rejoin_s']:g} s",
        "intervals": f"{given['outcomes']['confidence']:.0%}, bootstrap of {given['outcomes']['bootstrap']} over"
        " vehicles; Wilson's for shares",
        "engine": given["engine"],
        "gpsec": f"{stated['gpsec_version']}, commit {stated['git_commit'] or 'unknown'},"
        f" libsumo {stated['versions']['libsumo']}",
    }
    security_s = sum(stated["stages_s"].values())
    cost = (
        f"SUMO {stated['sumo_s']:.1f} s, security layer {security_s:.1f} s,"
        f" {security_s / max(stated['vehicle_steps'], 1) * 1e6:.1f} µs for each vehicle and step"
    )
    return {"name": stated["scenario"], "facts": facts | {"cost": cost}, "plans": plans, "notes": stated["notes"]}


def _pictured(stated: Mapping[str, Any]) -> dict[str, str]:
    """Return which vehicles saw pictures, nothing where nobody did."""
    who = stated.get("pixels", {}).get("vehicles", {})
    if not who:
        return {}
    pictures, lanes = (sum(one[key] for one in who.values()) for key in ("pictures", "lanes"))
    named = ", ".join(list(who)[:_NAMED]) + (f" and {len(who) - _NAMED} more" if len(who) > _NAMED else "")
    weather = stated["configuration"]["fleet"]["camera"]["image_weather"]
    return {
        "lanes by rendered pictures": f"{named}: a lane in {lanes / max(pictures, 1):.1%} of {pictures:,} pictures"
        f" (weather {weather})"
    }


def _unknown(world: Mapping[str, Any]) -> str:
    """Return the keys of `[world]` that are not as filters and detectors take them to be."""
    known = {key: field.default for key, field in WorldSection.model_fields.items()}
    differing = [f"{key} {_value(value)}" for key, value in world.items() if value != known.get(key)]
    return ", ".join(differing) or "nothing: noise and map are as stated"


def _value(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
