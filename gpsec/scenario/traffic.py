"""SUMO's options for a scenario."""

from gpsec.scenario.model import Scenario
from gpsec.traffic.options import SumoOptions, resolve_options


def sumo_options(scenario: Scenario) -> SumoOptions:
    """Return the options of the scenario's simulation.

    Raises:
        GpsecError: a file is missing, or an option is wrong.
    """
    return resolve_options(
        scenario.sumocfg,
        seed=scenario.seed,
        step_s=scenario.traffic.step_s,
        lateral_resolution_m=scenario.traffic.lateral_resolution_m,
        begin_s=scenario.traffic.begin_s,
        closed_loop=scenario.closed_loop.world is not None,
    )
