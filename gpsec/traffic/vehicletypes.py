"""What the fleet needs to know of SUMO's vehicle types."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.traffic.input_files import input_files
from gpsec.traffic.inputs import all_matches, own_parameters
from gpsec.traffic.vehicle_attacks import carried_attacks
from gpsec.types.attack_inputs import ATTACK_KEY
from gpsec.types.constants import PREFIX

# Everything that drives on roads with four wheels or more, for which the single-track body, the lane camera and the
# odometer stand. Left out: rail and ships; pedestrians; bicycle, moped, motorcycle and scooter, which lean and
# filter between lanes; `ignoring`, which may drive where there is no road.
ROAD_CLASSES = frozenset(
    {
        "private",
        "emergency",
        "authority",
        "army",
        "vip",
        "passenger",
        "hov",
        "taxi",
        "bus",
        "coach",
        "delivery",
        "truck",
        "trailer",
        "evehicle",
        "custom1",
        "custom2",
    }
)

_TYPE_ID = rb"""<vType(?:Distribution)?\s[^>]*?\bid\s*=\s*["']([^"']+)["']"""
TYPE_KEYS = (f"{PREFIX}equipped", f"{PREFIX}sensors")


@dataclass(frozen=True)
class VehicleType:
    """A SUMO vehicle type.

    Attributes:
        vehicle_class: SUMO's vClass.
        length_m, width_m: of the body.
        equipped_share: probability that a vehicle of it is equipped, None where the type does not say.
        sensors: name of a sensor profile, None where the type does not say.
        on_roads: it can be part of the fleet.
    """

    vehicle_class: str
    length_m: float
    width_m: float
    equipped_share: float | None
    sensors: str | None
    on_roads: bool


def read_type(type_id: str) -> VehicleType:
    """Ask the running simulation for the type `type_id`.

    Raises:
        GpsecError: its ``gpsec.equipped`` is no probability, or its body has no size.
    """
    import libsumo  # late: the evaluator only looks into files

    types = libsumo.vehicletype
    vehicle_class = types.getVehicleClass(type_id)
    for name, size_m in (("length", types.getLength(type_id)), ("width", types.getWidth(type_id))):
        if not 0.0 < size_m < inf:
            raise GpsecError(f"vType '{shown(type_id)}': {name}: expected a number of metres above 0, found {size_m:g}")
    return VehicleType(
        vehicle_class=vehicle_class,
        length_m=types.getLength(type_id),
        width_m=types.getWidth(type_id),
        equipped_share=_share(f"vType '{shown(type_id)}'", types.getParameter(type_id, "gpsec.equipped")),
        sensors=types.getParameter(type_id, "gpsec.sensors") or None,
        on_roads=vehicle_class in ROAD_CLASSES,
    )


def check_type_keys(files: tuple[Path, ...]) -> None:
    """Refuse parameters of vehicle types in `files` that start with ``gpsec.`` and mean nothing.

    The simulation shows them as well, but only when the first vehicle of the type departs.

    Raises:
        GpsecError: naming the file, the type and the key.
    """
    spoofers = {attack.owner_id for attack in carried_attacks(files) if attack.element == "vType"}
    for file in files:
        for found in own_parameters(file):
            where = f"{found.file}: {shown(found.element)} '{shown(found.owner_id)}'"
            if found.element != "vType":
                if found.key in TYPE_KEYS:
                    raise GpsecError(
                        f"{where}: parameter '{shown(found.key)}': expected it in a vType, for all vehicles of the type"
                    )
                continue
            if found.owner_id in spoofers:
                if found.key in TYPE_KEYS:
                    raise GpsecError(
                        f"{where}: parameter '{shown(found.key)}': expected none beside '{ATTACK_KEY}', since a "
                        "spoofer is not part of the fleet"
                    )
            elif found.key not in TYPE_KEYS:
                raise GpsecError(
                    f"{where}: unknown parameter '{shown(found.key)}': {nearest(found.key, (*TYPE_KEYS, ATTACK_KEY))}"
                )
            if found.key == f"{PREFIX}equipped":
                _share(where, found.value)


def check_type_names(names: Sequence[str], files: tuple[Path, ...], where: str) -> None:
    """Refuse names of vehicle types that none of SUMO's input `files` has.

    Raises:
        GpsecError: naming `where` they stand, and the nearest that there is.
    """
    unknown = [name for name in names if not name.startswith("DEFAULT_")]
    if not unknown:
        return
    known = {name for file in input_files(files) for name in all_matches(file, _TYPE_ID)}
    for name in unknown:
        if name not in known:
            choices = nearest(name, known) if known else "the scenario defines none"
            raise GpsecError(f"{where}: unknown vehicle type '{shown(name)}': {choices}")


def named_sensors(files: tuple[Path, ...]) -> dict[str, str]:
    """Return the sensor profiles that vehicle types in `files` name, with where they do, for error messages."""
    return {
        found.value: f"{found.file}: vType '{shown(found.owner_id)}'"
        for file in files
        for found in own_parameters(file)
        if found.element == "vType" and found.key == f"{PREFIX}sensors" and found.value
    }


def _share(where: str, text: str) -> float | None:
    if not text:
        return None
    try:
        share = float(text)
    except ValueError:
        share = -1.0
    if not 0.0 <= share <= 1.0:
        raise GpsecError(
            f"{where}: parameter '{PREFIX}equipped': expected a probability from 0 to 1, found '{shown(text)}'"
        )
    return share
