"""A scenario in closed loop: a run for each world and seed, and the benign twins of the worlds."""

from collections.abc import Sequence

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.outcomes.naming import world_name
from gpsec.scenario.closed_loop import BENIGN, DRIVE_ON, ClosedLoopSection, ClosedWorld
from gpsec.scenario.model import Scenario
from gpsec.scenario.traffic import sumo_options
from gpsec.sensors.registry import PROFILES
from gpsec.types.constants import UNDEFENDED

# A profile whose fixes are worse cannot keep a lane by them.
STEERING_SIGMA_M = 0.5
# Of worlds and seeds together. This bounds time, not memory: only so many are run at a time as there are cores, but at
# half a minute each these take eight hours on two of them, and more are rather a slip than a wish.
MOST_WORLDS = 2000
MOST_FALSE_ALARMS_PER_H = 3600


def can_steer(profile: str) -> bool:
    """Return whether a vehicle with that sensor profile can keep its lane by its fixes."""
    gnss = PROFILES[profile].gnss
    return bool(gnss.white_m**2 + gnss.bias_m**2 <= STEERING_SIGMA_M**2)


def worlds_of(scenario: Scenario) -> list[ClosedWorld]:
    """Return the worlds of a scenario, each with its reaction; the benign twins come first.

    Raises:
        GpsecError: a plan or a defence is not one of the scenario, no profile can steer, or the engine is another one.
    """
    section, plans = scenario.closed_loop, [plan.name for plan in scenario.plans]
    defences, where = [defence.name for defence in scenario.defences], f"scenario '{scenario.name}'"
    if scenario.engine != "batched":
        raise GpsecError(f"{where}: closed_loop: expected engine 'batched', found '{scenario.engine}'")
    if not any(can_steer(name) for name in scenario.fleet.profile):
        raise GpsecError(
            f"{where}: fleet.profile: expected one whose fixes are within {STEERING_SIGMA_M:g} m (1 σ) in closed loop,"
            f" found {', '.join(scenario.fleet.profile)}: such a vehicle leaves its lane by itself"
        )
    if not section.worlds and not plans:
        raise GpsecError(f"{where}: closed_loop.worlds: expected a plan to attack by, found no plans")
    asked = section.worlds or tuple(
        ClosedWorld(plan=plans[0], defence=defence) for defence in dict.fromkeys((UNDEFENDED, defences[-1]))
    )
    for place, world in enumerate(asked):
        for key, name, known in (("plan", world.plan, [BENIGN, *plans]), ("defence", world.defence, defences)):
            if name not in known:
                raise GpsecError(
                    f"{where}: closed_loop.worlds.{place}.{key}: unknown {key} '{shown(name)}': {nearest(name, known)}"
                )
    whole = [world.model_copy(update={"on_alarm": world.on_alarm or section.on_alarm}) for world in asked]
    return list(dict.fromkeys([*(_twin(world, section) for world in whole), *whole]))


def _twin(world: ClosedWorld, section: ClosedLoopSection) -> ClosedWorld:
    """Return the benign twin of a world; where nobody would be steered in it, it is the same for all defences."""
    alike = section.steer == "attacked" and world.on_alarm == DRIVE_ON
    defence = UNDEFENDED if alike else world.defence
    return world.model_copy(update={"plan": BENIGN, "defence": defence, "false_alarms_per_h": 0.0})


def with_false_alarms(scenario: Scenario, rates_per_h: Sequence[float]) -> Scenario:
    """Return a scenario whose worlds have no attack but false alarms, undefended, at each rate in a vehicle-hour.

    They stop on an alarm where the scenario has no other reaction than to drive on.

    Raises:
        GpsecError: a rate is not one that there can be.
    """
    section = scenario.closed_loop
    reaction = "stop" if section.on_alarm == DRIVE_ON else section.on_alarm
    for rate in rates_per_h:
        if not 0.0 <= rate <= MOST_FALSE_ALARMS_PER_H:
            raise GpsecError(f"false alarms: expected 0 to {MOST_FALSE_ALARMS_PER_H} a vehicle-hour, found {rate:g}")
    worlds = tuple(ClosedWorld(on_alarm=reaction, false_alarms_per_h=rate) for rate in rates_per_h)
    return scenario.model_copy(update={"closed_loop": section.model_copy(update={"worlds": worlds})})


def with_worlds(scenario: Scenario, seeds: Sequence[int]) -> list[Scenario]:
    """Return a scenario for each world and each seed, named after both.

    Raises:
        GpsecError: see `worlds_of`; or there are more than `MOST_WORLDS`, or SUMO cannot run them as it is told.
    """
    worlds = worlds_of(scenario)
    if len(worlds) * len(seeds) > MOST_WORLDS:
        raise GpsecError(
            f"scenario '{scenario.name}': closed_loop: expected at most {MOST_WORLDS} worlds in all, found"
            f" {len(worlds)} × {len(seeds)} seeds; a run for each part of the seeds takes more"
        )
    found = [_of_world(scenario, number, world, seed) for number, world in enumerate(worlds) for seed in seeds]
    sumo_options(found[0])  # what is wrong with them is wrong with all: it is said once
    return found


def shown_world(scenario: Scenario, plan: str | None, defence: str | None) -> Scenario:
    """Return the world of a scenario that is shown, with its own seed: the first with an attack, that plan and defence.

    Raises:
        GpsecError: see `worlds_of`; or there is no such world.
    """
    worlds = [world for world in worlds_of(scenario) if world.plan != BENIGN]
    for option, key, asked in (("--gui-plan", "plan", plan), ("--gui-defence", "defence", defence)):
        known = list(dict.fromkeys(getattr(world, key) for world in worlds))
        if asked is not None and asked not in known:
            raise GpsecError(f"{option}: no world in closed loop has {key} '{shown(asked)}': {nearest(asked, known)}")
        worlds = [world for world in worlds if asked is None or getattr(world, key) == asked]
    if not worlds:
        raise GpsecError("--gui: expected a world with an attack to show, found none")
    found = _of_world(scenario, 0, worlds[0], scenario.seed)
    sumo_options(found)
    return found


def _of_world(scenario: Scenario, number: int, world: ClosedWorld, seed: int) -> Scenario:
    closed_loop = scenario.closed_loop.model_copy(update={"worlds": (), "seeds": 1, "world": world})
    return scenario.model_copy(
        update={
            "name": world_name(scenario.name, number, seed),
            "seed": seed,
            "plans": tuple(plan for plan in scenario.plans if plan.name == world.plan),
            "closed_loop": closed_loop,
        }
    )
