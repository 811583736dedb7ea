"""Writes the page of a run in closed loop: what attacks do to traffic, where vehicles crash, and how."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gpsec.core.version import __version__
from gpsec.outcomes.naming import scenario_of_world
from gpsec.report.about import described
from gpsec.report.page import render, write_page
from gpsec.report.worlds_crash import crash_figures
from gpsec.report.worlds_map import collision_map, first_worlds
from gpsec.report.worlds_road import road_figure
from gpsec.report.worlds_tables import attacks_of, effect_tables, effects_figure, false_alarm_figure, sentences
from gpsec.running.results import Results


def write_worlds(run: Results, path: Path) -> Path:
    """Write the page of a run in closed loop to `path`, and return it.

    Raises:
        GpsecError: the manifest does not say where the net lies.
    """
    made = [effects_figure(run), false_alarm_figure(run), collision_map(run), road_figure(run), *crash_figures(run)]
    figures = {figure.key: figure for figure in made if figure is not None}
    groups = list(dict.fromkeys(scenario_of_world(stated["scenario"]) for stated in run.scenarios))
    attacks = attacks_of(run)
    page = render(
        "worlds.html",
        {"figures": {key: figure.plain() for key, figure in figures.items()}, "groups": groups, "attacks": attacks},
        title=", ".join(groups) + " in closed loop",
        unfinished=run.unfinished,
        changed=run.changed,
        sentences=sentences(run),
        tables=effect_tables(run),
        figures=figures,
        costs="false_alarms" in figures,
        runs=[_described(run, name, stated) for name, stated in first_worlds(run).items()],
        groups=groups,
        attacks=attacks,
        version=__version__,
    )
    write_page(path, page)
    return path


def _described(run: Results, name: str, stated: dict[str, Any]) -> dict[str, Any]:
    """Return the facts that the page lists of a scenario: those of its first world, and what holds of all."""
    mine = [one for one in run.scenarios if scenario_of_world(one["scenario"]) == name]
    found = described(stated)
    facts = {
        "worlds": f"{len(mine)}, with their benign twins; what follows is of the first, {stated['scenario']}",
        "closed loop": _settings(stated["configuration"].get("closed_loop", {})),
        **found["facts"],
    }
    plans = {plan["name"]: plan for one in mine for plan in described(one)["plans"]}
    notes = dict.fromkeys(note for one in mine for note in one["notes"])
    return {"name": name, "facts": facts, "plans": list(plans.values()), "notes": list(notes)}


def _settings(section: Mapping[str, Any]) -> str:
    shown = {key: value for key, value in section.items() if key not in {"world", "worlds", "seeds"} and value != {}}
    return ", ".join(f"{key} {value}" for key, value in shown.items())
