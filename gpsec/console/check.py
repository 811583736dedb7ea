"""`gpsec check`: everything that can be wrong before a run begins."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gpsec.console import options
from gpsec.console.errors import complain, say
from gpsec.core.errors import GpsecError

if TYPE_CHECKING:
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override


def check(
    scenarios: options.Scenarios,
    profile: options.Profile = None,
    set_: options.Set = None,
    part: options.Part = None,
    allow_code: options.AllowCode = False,
) -> int:
    """Validate scenarios without running them: configuration, files, net, and what SUMO says of them.

    \b
    Examples:
      gpsec check scenarios/town
      gpsec check scenarios/* --set fleet.profile=consumer
    """  # noqa: D301
    from gpsec.scenario.outside import Outside

    wanted = options.changes(set_, profile)
    found = set()
    for argument in scenarios:
        try:
            for line in _lines(argument, wanted, Outside(tuple(part or ()), allow_code)):
                say(line)
        except GpsecError as error:
            found.add(complain(error))
    return min(found, default=0)  # a fault of the machine comes before those of the user


def _lines(argument: str, overrides: "Sequence[Override]", outside: "Outside") -> list[str]:
    """Return a line on a scenario that can be run, then one on each thing that SUMO warns of.

    Raises:
        GpsecError: something of it is wrong.
    """
    from gpsec.running.checking import check_scenario
    from gpsec.scenario import load_scenario

    done = check_scenario(load_scenario(argument, overrides, outside))
    return [
        f"{done.scenario.name}: ok ({done.lanes} lanes, {1 + len(done.plans)} plans with none, "
        f"{len(done.scenario.defences)} defences, profiles {', '.join(done.profiles)})",
        *(f"  {warning}" for warning in done.warnings),
    ]
