"""Plans of one simulation in the place of many simulations: parameters of attacks, and shares, in open loop.

In open loop an attack does not change the traffic, so that plans which differ in their parameters are cells of one
simulation. Who is attacked, and who is equipped, is drawn from seed and vehicle: a smaller share is a subset of a
larger one, so that the largest is simulated and the others are filtered.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

from gpsec.attacks.plans import PlanConfig
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.scenario import Scenario
from gpsec.scenario.load import changed
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import of_keywords
from gpsec.scenario.traffic import sumo_options
from gpsec.sweeps.plan import SweepGrid
from gpsec.sweeps.points import Cell
from gpsec.traffic.inputs import own_parameters
from gpsec.types.constants import PREFIX

EQUIPPED = "fleet.equipped_share"
# Time and memory of a simulation grow with its plans; SUMO's share is small long before.
MOST_PLANS = 64
_CODE = Outside(allow_code=True)  # what a scenario names is loaded already


class Simulation(NamedTuple):
    """A scenario whose plans stand for cells of the grid."""

    scenario: Scenario
    cells: dict[str, Cell]
    equipped: tuple[float, ...] = ()


def varied(scenario: Scenario, parameters: dict[str, Any]) -> Scenario:
    """Return a scenario with some keys changed.

    Raises:
        GpsecError: a key or a value is not one that there is.
    """
    return changed(scenario, of_keywords(parameters), _CODE)


def combinations(grid: SweepGrid) -> Iterator[dict[str, Any]]:
    """Yield every choice of one value for each key."""
    for values in product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def simulations(scenario: Scenario, grid: SweepGrid) -> Iterator[tuple[dict[str, Any], Simulation]]:
    """Yield the simulations that serve a grid in open loop, and the parameters of each as a whole.

    Raises:
        GpsecError: a key or a value is not one that there is, or a plan is unknown.
    """
    attacks = {key: values for key, values in grid.items() if key.startswith("plans.") and key.count(".") >= 2}
    rest = {key: values for key, values in grid.items() if key not in attacks and key != EQUIPPED}
    for parameters in combinations(rest):
        one = varied(scenario, parameters)
        shares = grid.get(EQUIPPED)
        if shares is None:
            whole: list[tuple[dict[str, Any], Scenario, tuple[float, ...]]] = [(parameters, one, ())]
        elif may_be_filtered(one):
            served = _shares(EQUIPPED, shares)
            varied(one, {EQUIPPED: served[0]})
            whole = [(parameters, varied(one, {EQUIPPED: served[-1]}), served)]
        else:
            whole = [({**parameters, EQUIPPED: share}, varied(one, {EQUIPPED: share}), ()) for share in shares]
        for of, fleet, equipped in whole:
            for plans, cells in _plans(fleet, attacks):
                yield of, Simulation(fleet.model_copy(update={"plans": plans}), cells, equipped)


def may_be_filtered(scenario: Scenario) -> bool:
    """Return whether a smaller equipped share is a subset of a larger one.

    It is not where cameras look at the rest of the fleet, or where vehicle types have shares of their own.
    """
    options = sumo_options(scenario)
    files = (*options.additional_files, *options.route_files)
    typed = any(found.key == f"{PREFIX}equipped" for file in files for found in own_parameters(file))
    return scenario.fleet.camera.visibility == "clock" and not typed


def _plans(scenario: Scenario, attacks: SweepGrid) -> Iterator[tuple[tuple[PlanConfig, ...], dict[str, Cell]]]:
    """Yield the plans of each simulation, at most `MOST_PLANS`, and those among them that are cells of the grid."""
    of_plan: dict[str, SweepGrid] = {}
    known = [plan.name for plan in scenario.plans]
    for key, values in attacks.items():
        name = next((one for one in known if key.startswith(f"plans.{one}.")), "")
        if not name:
            raise GpsecError(f"{key}: no plan is called so: {nearest(key.split('.')[1], known)}")
        of_plan.setdefault(name, {})[key] = values
    made: list[tuple[PlanConfig, Cell | None]] = []
    for place, plan in enumerate(scenario.plans):
        made += _variants(scenario, place, of_plan[plan.name]) if plan.name in of_plan else [(plan, None)]
    for begin in range(0, max(len(made), 1), MOST_PLANS):
        some = made[begin : begin + MOST_PLANS]
        yield tuple(plan for plan, _ in some), {plan.name: cell for plan, cell in some if cell is not None}


def _variants(scenario: Scenario, place: int, grid: SweepGrid) -> list[tuple[PlanConfig, Cell]]:
    """Return one plan for each combination of the parameters of a plan, with the largest of its shares."""
    name = scenario.plans[place].name
    share_key = f"plans.{name}.share"
    shares = _shares(share_key, grid[share_key]) if share_key in grid else ()
    choices = list(combinations({key: values for key, values in grid.items() if key != share_key}))
    found = []
    for number, parameters in enumerate(choices, start=1):
        for share in shares[:1]:
            varied(scenario, {share_key: share})
        largest = {share_key: shares[-1]} if shares else {}
        plan = varied(scenario, {**parameters, **largest}).plans[place]
        called = name if len(choices) == 1 else f"{name}~{number}"
        cell = Cell(plan=name, parameters=parameters, share_key=share_key if shares else "", shares=shares)
        found.append((plan.model_copy(update={"name": called}), cell))
    return found


def _shares(key: str, values: Sequence[Any]) -> tuple[float, ...]:
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise GpsecError(f"{key}: expected numbers from 0 to 1, found {shown(repr(value))}")
    return tuple(sorted(float(value) for value in values))
