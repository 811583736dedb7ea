"""From a plan to the simulations that it takes: cells first, then seeds."""

import json
from collections.abc import Iterator
from math import prod
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import of_keywords
from gpsec.scenario.parts import is_code, relocate
from gpsec.scenario.worlds import with_worlds
from gpsec.sweeps.cells import combinations, simulations, varied
from gpsec.sweeps.plan import SweepEntry, SweepPlan
from gpsec.sweeps.points import ListedTask, Point

MOST_RUNS = 1_000_000
_LONGEST_VALUE = 40


def count_of(plan: SweepPlan) -> int:
    """Return how many runs a plan would take, were each combination of its grid one; worlds are not counted."""
    return sum(
        len(entry.scenarios) * max(len(entry.seeds), 1) * prod(map(len, entry.grid.values())) for entry in plan.entries
    )


def listed(plan: SweepPlan, file: Path, allow_code: bool = False) -> Iterator[ListedTask]:
    """Yield the simulations of a plan that was read from `file`.

    Raises:
        GpsecError: a scenario, a key or a value is not one that there is, or there are too many.
    """
    if (count := count_of(plan)) > MOST_RUNS:
        raise GpsecError(f"{file}: expected at most {MOST_RUNS:,} combinations in all, found {count:,}")
    for entry in plan.entries:
        try:
            yield from _of_entry(plan, entry, file, allow_code)
        except GpsecError as error:
            raise type(error)(f"{file}: entry '{entry.name}': {error}") from None


def _of_entry(plan: SweepPlan, entry: SweepEntry, file: Path, allow_code: bool) -> Iterator[ListedTask]:
    for part in plan.parts:
        if is_code(part) and not allow_code:
            raise GpsecError(
                f"parts: '{shown(part)}' is code, and a plan may come from somebody else; --allow-code runs it"
            )
    parts = [relocate(part, lambda place: str((file.parent / place).resolve())) for part in plan.parts]
    changes = of_keywords({**({"parts": parts} if parts else {}), **plan.set, **entry.set})
    outside = Outside(allow_code=allow_code)
    names: dict[str, str] = {}
    for argument in entry.scenarios:
        beside = file.parent / argument
        scenario = load_scenario(beside if beside.exists() else argument, changes, outside)
        if scenario.name in names:
            raise GpsecError(
                f"scenarios: '{shown(argument)}' and '{shown(names[scenario.name])}' have one name, "
                f"'{scenario.name}'; put them into two entries"
            )
        names[scenario.name] = argument
        made = _worlds(entry, scenario) if entry.closed_loop else _open_loop(entry, scenario)
        for label, run, point in made:
            yield ListedTask(fingerprint=fingerprint(run), label=label, point=point, told=run.model_dump_json())


def _open_loop(entry: SweepEntry, scenario: Scenario) -> Iterator[tuple[str, Scenario, Point]]:
    numbers: dict[str, int] = {}
    for parameters, simulation in simulations(scenario, entry.grid):
        label = _label(entry, scenario, parameters)
        numbers[label] = number = numbers.get(label, 0) + 1
        for seed in entry.seeds or (scenario.seed,):
            run = simulation.scenario.model_copy(update={"seed": seed})
            point = Point(
                entry=entry.name,
                scenario=scenario.name,
                seed=seed,
                parameters=parameters,
                cells=simulation.cells,
                equipped=simulation.equipped,
            )
            yield f"{label} seed={seed}{f' plans {number}' if number > 1 else ''}", run, point


def _worlds(entry: SweepEntry, scenario: Scenario) -> Iterator[tuple[str, Scenario, Point]]:
    for key in entry.grid:
        if key.startswith("plans.") and key.split(".")[1] not in [plan.name for plan in scenario.plans]:
            known = nearest(key.split(".")[1], [plan.name for plan in scenario.plans])
            raise GpsecError(f"{key}: no plan is called so: {known}")
    for parameters in combinations(entry.grid):
        one = varied(scenario, parameters)
        for run in with_worlds(one, entry.seeds or (one.seed,)):
            world = run.closed_loop.world
            steering = "" if world is None else f" world={world.plan}/{world.defence}/{world.on_alarm}"
            point = Point(entry=entry.name, scenario=scenario.name, seed=run.seed, parameters=parameters)
            yield f"{_label(entry, scenario, parameters)}{steering} seed={run.seed}", run, point


def _label(entry: SweepEntry, scenario: Scenario, parameters: dict[str, Any]) -> str:
    said = [f"{key}={_value(value)}" for key, value in parameters.items()]
    return " ".join([entry.name, scenario.name, *said])


def _value(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
    return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 1]}…"
