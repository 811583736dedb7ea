"""Simulates vehicles of a run again, from the scenario in its manifest, to obtain steps that were not logged."""

import tempfile
from collections.abc import Collection, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import ValidationError

from gpsec.core.errors import GpsecError, shown
from gpsec.core.progress import Report
from gpsec.core.threads import cores
from gpsec.outcomes.tables import STEP_LOG, read_table
from gpsec.running.results import Results
from gpsec.running.workers import run_scenarios
from gpsec.scenario import Scenario
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.config import is_file

_KEYS = ["vehicle_id", "attack", "defence"]
# Columns by which the new simulation of a vehicle is compared with the run.
_COMPARED = {
    "events": ["start_s", "rmse_xy_m"],
    "vehicles": ["depart_s", "arrive_s", "scored_seconds", "alarms", "rmse_xy_m", "max_cross_track_m"],
}


def simulate(run: Results, wanted: Mapping[str, Collection[str]], tell: Report) -> dict[str, pd.DataFrame | None]:
    """Return the steps of the `wanted` vehicles of each scenario, simulated again with these alone equipped.

    Where cameras see the other vehicles, all are equipped again, as they were.

    Raises:
        GpsecError: the traffic of the run is not there any more, or its vehicles do not do what they did.

    """
    scenarios = [_scenario(run, name, vehicles) for name, vehicles in wanted.items()]
    only = {
        scenario.name: tuple(vehicles)
        for scenario, vehicles in zip(scenarios, wanted.values(), strict=True)
        if not _see_each_other(run, scenario)
    }
    found: dict[str, pd.DataFrame | None] = {}
    with tempfile.TemporaryDirectory(prefix="gpsec-again-") as folder:
        outcome = run_scenarios(scenarios, Path(folder), cores(), tell, partial(_run, only=only))
        if outcome.interrupted:
            raise KeyboardInterrupt
        for failure in outcome.failures:
            raise failure.kind(f"scenario '{shown(failure.scenario)}' cannot be simulated again: {failure.sentence}")
        for name, vehicles in wanted.items():
            _check(run, name, vehicles, Path(folder) / name)
            found[name] = pd.read_parquet(Path(folder) / name / STEP_LOG)
    return found


def _run(scenario: Scenario, folder: Path, report: Report, only: Mapping[str, Collection[str]]) -> None:
    from gpsec.pipeline.run import run_scenario
    from gpsec.replay.prepare import order_of
    from gpsec.replay.running import replay_log

    again = run_scenario if order_of(scenario) is None else replay_log
    again(scenario, folder, report, only=only.get(scenario.name))


def _see_each_other(run: Results, scenario: Scenario) -> bool:
    """Return whether vehicles are in the view of each other's cameras, so that the whole fleet has to be there."""
    from gpsec.pipeline.mismatch import cameras_by_place

    profiles = [PROFILES[name] for name in run.manifest(scenario.name)["profiles"]]
    return scenario.fleet.camera.source == "image" or any(cameras_by_place(scenario, profiles))


def found_from(folder: Path, named: Path) -> Path | None:
    """Return where a file is that a run in `folder` names: seen from one of the folders that it lies in, else None.

    A run names it as it was given, from where gpsec was started, which mostly is above where the run lies.
    """
    return next((place / named for place in folder.resolve().parents if is_file(place / named)), None)


def _scenario(run: Results, name: str, vehicles: Collection[str]) -> Scenario:
    """Return the scenario as it was run, up to the time at which the last of the vehicles left."""
    stated = run.manifest(name)
    try:
        scenario = Scenario.model_validate(stated["configuration"])
    except ValidationError as error:
        said = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise GpsecError(f"{run.folder}: the configuration of '{shown(name)}' cannot be run here: {said}") from None
    named = Path(str(stated["configuration"]["sumocfg"]))
    traffic = scenario.sumocfg if is_file(scenario.sumocfg) else found_from(run.folder, named)
    if traffic is None:
        raise GpsecError(
            f"{shown(scenario.sumocfg)}: the traffic of '{shown(name)}' is not there, so that its vehicles cannot be"
            " simulated again; start gpsec where the run was started"
        )
    changes: dict[str, Any] = {"sumocfg": traffic, "log_steps": True, "log_vehicles": (), "threads": 1}
    if _see_each_other(run, scenario):
        changes |= {"log_steps": False, "log_vehicles": tuple(vehicles)}
    journeys = run.vehicles[(run.vehicles["scenario"] == name) & run.vehicles["vehicle_id"].isin(list(vehicles))]
    if journeys["arrive_s"].notna().all():
        # A second more, for the step in which they are seen to have left.
        changes["duration_s"] = min(float(journeys["arrive_s"].max()) + 1.0, stated["steps"] * stated["step_s"])
    return scenario.model_copy(update=changes)


def _check(run: Results, name: str, vehicles: Collection[str], folder: Path) -> None:
    """Check that the vehicles have the same figures as in the run.

    Raises:
        GpsecError: they did not.
    """
    for table, figures in _COMPARED.items():
        now, then = (
            _rows(found, name, vehicles, figures) for found in (read_table(folder, table), getattr(run, table))
        )
        if not now.equals(then):
            raise GpsecError(
                f"{run.folder}: the vehicles of '{shown(name)}' do not do what they did in this run, so that gpsec,"
                " SUMO or the scenario's files have changed since; run it again"
            )


def _rows(table: pd.DataFrame, name: str, vehicles: Collection[str], figures: list[str]) -> pd.DataFrame:
    """Return the compared columns of some vehicles, sorted, with fixed types."""
    mine = table.loc[(table["scenario"] == name) & table["vehicle_id"].isin(list(vehicles)), [*_KEYS, *figures]]
    types = dict.fromkeys(_KEYS, str) | dict.fromkeys(figures, float)
    return mine.astype(types).sort_values(_KEYS, ignore_index=True)
