"""Everything that can be wrong before a run begins."""

from dataclasses import dataclass, field, replace

from gpsec.core.errors import GpsecError
from gpsec.scenario import Scenario

_ROUTE_STEPS = "--route-steps"


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

    All vehicles, flows and routes are read, also those of later. What is only found when SUMO takes steps is not: that
    a trip has no way to its end, that a vehicle is inserted where there is no room, or that nobody ever departs.

    Raises:
        GpsecError: something of it is wrong.
    """
    # Late: a wrong key is said before SUMO and the models are loaded.
    try:
        return _look(scenario)
    except GpsecError as error:
        raise type(error)(f"scenario '{scenario.name}': {error}") from None


def _look(scenario: Scenario) -> Checked:
    from gpsec.pipeline.build import drawn_zones, lay_ground, make_detection, make_plans
    from gpsec.pipeline.mismatch import make_shared_errors
    from gpsec.traffic.remote import RemoteSession
    from gpsec.traffic.stderr import input_warnings

    ground = lay_ground(scenario)
    make_detection(scenario, ground)
    # As it is run, SUMO reads routes some minutes ahead, and meets what is wrong in them no sooner.
    options = replace(ground.options, arguments=_reading_all_routes(ground.options.arguments))
    with RemoteSession(options, ground.hd_map.lane_index, ground.choice.equipped) as session:
        zones = drawn_zones(session)
        plans = make_plans(scenario, ground, ground.options, zones)
        make_shared_errors(scenario, ground.sensors, ground.hd_map, zones)
        for _ in session.frames(0.0):  # none, but SUMO's warnings come at their end
            pass
    return Checked(
        scenario,
        len(ground.hd_map.lane_ids),
        tuple(plan.name for plan in plans),
        tuple(ground.choice.profiles),
        tuple(input_warnings(session.warnings)),
    )


def _reading_all_routes(arguments: tuple[str, ...]) -> tuple[str, ...]:
    """Return SUMO's arguments, in pairs, with one that lets it read all route files at the start."""
    pairs = zip(arguments[::2], arguments[1::2], strict=True)
    kept = [part for name, value in pairs if name != _ROUTE_STEPS for part in (name, value)]
    return (*kept, _ROUTE_STEPS, "0")
