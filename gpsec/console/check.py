"""`gpsec check`: everything that can be wrong before a run begins."""

from collections.abc import Sequence

from gpsec.running.checking import check_scenario
from gpsec.scenario import load_scenario
from gpsec.scenario.outside import NOTHING, Outside
from gpsec.scenario.overrides import Override


def check_lines(argument: str, overrides: Sequence[Override], outside: Outside = NOTHING) -> list[str]:
    """Return a line on a scenario that can be run, then one on each thing that SUMO warns of.

    Raises:
        GpsecError: something of it is wrong.
    """
    done = check_scenario(load_scenario(argument, overrides, outside))
    return [
        f"{done.scenario.name}: ok ({done.lanes} lanes, {1 + len(done.plans)} plans with none, "
        f"{len(done.scenario.defences)} defences, profiles {', '.join(done.profiles)})",
        *(f"  {warning}" for warning in done.warnings),
    ]
