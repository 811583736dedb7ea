"""What the runs of a scenario with several seeds are called."""

import re

_SEEDED = re.compile(r"(?P<name>.+)-seed-(?P<seed>\d+)")


def seeded_name(scenario: str, seed: int) -> str:
    """Return the name of the run of a scenario with one of several seeds."""
    return f"{scenario}-seed-{seed}"


def base_name(scenario: str) -> str:
    """Return the scenario that a run belongs to, by its name."""
    found = _SEEDED.fullmatch(scenario)
    return found["name"] if found else scenario
