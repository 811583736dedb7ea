"""Attacks that vehicles carry: a spoofer that follows traffic, or a vehicle that is attacked by itself.

They are parameters in SUMO's input files, of a vehicle type, or of a vehicle, trip or flow. All plans of a run must be
known before the first vehicle departs, so that these are looked for in the files.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.traffic.inputs import own_parameters
from gpsec.types.attack_inputs import ATTACK_KEY, CarriedAttack

# SUMO gives −2³⁰ where a vehicle is nowhere.
NOWHERE_M = -1e9
# What may depart: elements of a route file that a vehicle gets its parameters from.
DEPARTING = ("vehicle", "trip", "flow")


def carried_attacks(files: Iterable[Path]) -> list[CarriedAttack]:
    """Return the attacks that vehicles and vehicle types in `files` carry, in the order in which they stand there."""
    found: dict[tuple[Path, str, str], CarriedAttack] = {}
    for file in files:
        for own in own_parameters(file):
            if own.element in ("vType", *DEPARTING):
                place = (own.file, own.element, own.owner_id)
                found.setdefault(place, CarriedAttack(*place)).parameters[own.key] = own.value
    return [attack for attack in found.values() if ATTACK_KEY in attack.parameters]


def check_departing(files: Iterable[Path]) -> None:
    """Refuse ``gpsec.…`` parameters of vehicles, trips and flows in `files` that stand there without an attack.

    Raises:
        GpsecError: naming the file, the vehicle and the key.
    """
    files = list(files)
    carry = {(attack.file, attack.element, attack.owner_id) for attack in carried_attacks(files)}
    for file in files:
        for own in own_parameters(file):
            if own.element in DEPARTING and (own.file, own.element, own.owner_id) not in carry:
                raise GpsecError(
                    f"{own.file}: {own.element} '{shown(own.owner_id)}': parameter '{shown(own.key)}': expected "
                    f"'{ATTACK_KEY}' beside it, found none"
                )


class Spoofers:
    """The vehicles in a running simulation that carry a spoofer. They are not part of the fleet."""

    def __init__(self, attacks: Iterable[CarriedAttack]) -> None:
        self._types: dict[str, str] = {}
        self._vehicles: dict[str, str] = {}
        self._flows: dict[str, str] = {}
        kinds = {"vType": self._types, "flow": self._flows}
        for attack in attacks:
            if attack.transmits:
                kinds.get(attack.element, self._vehicles)[attack.owner_id] = attack.plan
        self._any = bool(self._types or self._vehicles or self._flows)
        self._plan_of: dict[str, str] = {}

    def enter(self, vehicle_id: str, type_id: str) -> bool:
        """Return whether a vehicle that departs carries a spoofer, and if so keep an eye on it."""
        if not self._any:
            return False
        flow, dot, number = vehicle_id.rpartition(".")
        of_flow = self._flows.get(flow) if dot and number.isdecimal() else None
        plan = self._vehicles.get(vehicle_id) or of_flow or self._types.get(type_id)
        if plan is None:
            return False
        self._plan_of[vehicle_id] = plan
        return True

    def forget(self, vehicle_id: str) -> None:
        """Lose sight of a vehicle that has left the simulation, whether it carries one or not."""
        self._plan_of.pop(vehicle_id, None)

    def positions(self) -> dict[str, Floats]:
        """Return plan -> (n, 2) positions of the vehicles that carry its spoofer, in the order of their ids.

        One that is nowhere, such as in a teleport, is left out; one that is parked transmits from there.
        """
        if not self._plan_of:
            return {}
        import libsumo  # late: the evaluator only looks into files

        found: dict[str, list[tuple[float, float]]] = {}
        for vehicle_id in sorted(self._plan_of):
            x_m, y_m = libsumo.vehicle.getPosition(vehicle_id)
            if x_m > NOWHERE_M:
                found.setdefault(self._plan_of[vehicle_id], []).append((x_m, y_m))
        return {plan: np.array(places) for plan, places in found.items()}
