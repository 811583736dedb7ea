"""`gpsec check`: everything that can be wrong before a run begins."""

from collections.abc import Sequence

from gpsec.core.errors import GpsecError
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.outside import NOTHING, Outside
from gpsec.scenario.overrides import Override


def check_scenario(argument: str, overrides: Sequence[Override], outside: Outside = NOTHING) -> list[str]:
    """Return a line on a scenario that can be run, then one on each thing that SUMO warns of.

    Its configuration is read, its net compiled, its detectors' models loaded, and SUMO loads all of it, with the
    zones that are drawn in it, without taking a step.

    Raises:
        GpsecError: something of it is wrong.
    """
    scenario = load_scenario(argument, overrides, outside)
    # Late: a wrong key is said before SUMO and the models are loaded.
    try:
        return _look(scenario)
    except GpsecError as error:
        raise type(error)(f"scenario '{scenario.name}': {error}") from None


def _look(scenario: Scenario) -> list[str]:
    from gpsec.pipeline.build import lay_ground, make_plans, make_watchers
    from gpsec.traffic.remote import RemoteSession
    from gpsec.traffic.stderr import input_warnings

    ground = lay_ground(scenario)
    make_watchers(scenario, ground)
    with RemoteSession(ground.options, ground.hd_map.lane_index, ground.choice.equipped) as session:
        plans = make_plans(scenario, session)
        for _ in session.frames(0.0):  # none, but SUMO's warnings come at their end
            pass
    return [
        f"{scenario.name}: ok ({len(ground.hd_map.lane_ids)} lanes, {1 + len(plans)} plans with none, "
        f"{len(scenario.defences)} defences, profiles {', '.join(ground.choice.profiles)})",
        *(f"  {warning}" for warning in input_warnings(session.warnings)),
    ]
