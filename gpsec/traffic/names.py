"""Names of vehicles in tables: SUMO's id, or `id#2`, `id#3`, … for each time that it enters anew; none comes twice."""

from collections.abc import Iterable
from pathlib import Path

from gpsec.traffic.input_files import input_files
from gpsec.traffic.inputs import all_matches

# As programs write it. Names differ all the same where a hand has written it otherwise.
_NUMBERED = rb"""id=["']([^"']*#\d+)["']"""


def numbered_ids(files: Iterable[Path]) -> frozenset[str]:
    """Return the ids in SUMO's input files that are of the form ``id#2``: a vehicle may be called so itself."""
    return frozenset(name for file in input_files(files) for name in all_matches(file, _NUMBERED))


class VehicleNames:
    """Gives names to vehicles that enter the fleet."""

    def __init__(self, reserved: frozenset[str] = frozenset()) -> None:
        """Keep `reserved` for the vehicles that SUMO calls so, however late they depart."""
        self._reserved = reserved
        self._given: set[str] = set()
        self._last: dict[str, int] = {}

    def give(self, sumo_id: str) -> str:
        """Return a name for a vehicle that enters, for the first time or again: one that nobody had before."""
        number = self._last.get(sumo_id, 0) + 1
        name = sumo_id if number == 1 else f"{sumo_id}#{number}"
        while name in self._given or (number > 1 and name in self._reserved):
            number += 1
            name = f"{sumo_id}#{number}"
        self._last[sumo_id] = number
        self._given.add(name)
        return name


def first_life(vehicle_id: str) -> str:
    """Return SUMO's id of a vehicle by its name, unless SUMO itself calls it ``id#2``."""
    name, mark, life = vehicle_id.rpartition("#")
    return name if mark and life.isdigit() else vehicle_id
