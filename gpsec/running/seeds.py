"""One scenario with several seeds: a run for each."""

from collections.abc import Sequence

from gpsec.core.errors import GpsecError, shown
from gpsec.outcomes.naming import seeded_name
from gpsec.scenario import Scenario
from gpsec.scenario.load import changed
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import of_keywords

_MOST = 1000


def parse_seeds(text: str) -> tuple[int, ...]:
    """Return the seeds of a text such as ``1-10`` or ``1,4,7-9``, in order.

    Raises:
        GpsecError: it is something else, or a seed is there twice.
    """
    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not (first.isdecimal() and (last.isdecimal() or not dash)) or len(first) > 9 or len(last) > 9:
            raise GpsecError(f"seeds: expected numbers and ranges such as 1-10 or 1,4,7-9, found '{shown(text)}'")
        begin, end = int(first), int(last or first)
        if not begin <= end < begin + _MOST:
            raise GpsecError(f"seeds: expected ranges that go up, by less than {_MOST}, found '{shown(part)}'")
        seeds += range(begin, end + 1)
    if len(set(seeds)) < len(seeds):
        raise GpsecError(f"seeds: expected each once, found '{shown(text)}'")
    return tuple(sorted(seeds))


def with_seeds(scenario: Scenario, seeds: Sequence[int]) -> list[Scenario]:
    """Return a scenario for each seed, named after it; the scenario itself where there is none."""
    outside = Outside(allow_code=True)  # its code, if it has any, is loaded already
    return [
        changed(scenario, of_keywords({"seed": seed, "name": seeded_name(scenario.name, seed)}), outside)
        for seed in seeds
    ] or [scenario]
