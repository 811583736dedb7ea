"""Everything that can be wrong before a run begins."""

from dataclasses import dataclass, field

from gpsec.core.errors import GpsecError
from gpsec.scenario import Scenario


@dataclass(frozen=True)
class Checked:
    """A scenario that can be run.

    Attributes:
        scenario: with all that is not said resolved.
        lanes: number of lanes in the net.
        plans: names of the attack plans, those that are drawn in the scenario included; not that of no attack.
        profiles: names of the sensor profiles in the fleet.
        warnings: what SUMO warns of in its input.
    """

    scenario: Scenario = field(repr=False)
    lanes: int
    plans: tuple[str, ...]
    profiles: tuple[str, ...]
    warnings: tuple[str, ...]


def check_scenario(scenario: Scenario) -> Checked:
    """Compile the net, load the detectors' models, and let SUMO load all of the scenario without taking a step.

    Raises:
        GpsecError: something of it is wrong.
    """
    # Late: a wrong key is said before SUMO and the models are loaded.
    try:
        return _look(scenario)
    except GpsecError as error:
        raise type(error)(f"scenario '{scenario.name}': {error}") from None


def _look(scenario: Scenario) -> Checked:
    from gpsec.pipeline.build import lay_ground, make_detection, make_plans
    from gpsec.traffic.remote import RemoteSession
    from gpsec.traffic.stderr import input_warnings

    ground = lay_ground(scenario)
    make_detection(scenario, ground)
    with RemoteSession(ground.options, ground.hd_map.lane_index, ground.choice.equipped) as session:
        plans = make_plans(scenario, session)
        for _ in session.frames(0.0):  # none, but SUMO's warnings come at their end
            pass
    return Checked(
        scenario,
        len(ground.hd_map.lane_ids),
        tuple(plan.name for plan in plans),
        tuple(ground.choice.profiles),
        tuple(input_warnings(session.warnings)),
    )
