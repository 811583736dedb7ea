"""What the runs of a scenario with several seeds are called."""

import re

_WORLD = re.compile(r"(?P<name>.+)-world-\d+")
_SEEDED = re.compile(r"(?P<name>.+)-seed-(?P<seed>\d+)")


def seeded_name(scenario: str, seed: int) -> str:
    """Return the name of the run of a scenario with one of several seeds."""
    return f"{scenario}-seed-{seed}"


def base_name(scenario: str) -> str:
    """Return the scenario that a run belongs to, by its name."""
    found = _SEEDED.fullmatch(scenario)
    return found["name"] if found else scenario


def world_name(scenario: str, number: int, seed: int) -> str:
    """Return the name of the run of one of the worlds of a scenario with one of several seeds."""
    return seeded_name(f"{scenario}-world-{number:02d}", seed)


def scenario_of_world(name: str) -> str:
    """Return the scenario that a world belongs to, by its name."""
    found = _WORLD.fullmatch(base_name(name))
    return found["name"] if found else name
