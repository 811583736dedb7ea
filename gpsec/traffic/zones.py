"""Zones that a user has drawn in netedit: polygons and points of a type such as ``gpsec.attack``."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol
from xml.etree import ElementTree

import numpy as np

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.traffic.input_files import input_files
from gpsec.traffic.inputs import UNREADABLE, first_match, is_plain, open_input, own_parameters
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.vehicle_attacks import DEPARTING
from gpsec.types.attack_inputs import ATTACK_KEY
from gpsec.types.constants import PREFIX
from gpsec.types.drawn_zones import ATTACK_ZONE, DrawnZone

# Type of a zone -> the parameters, with the prefix, that it may have.
KeysOfTypes = Mapping[str, Collection[str]]
# SUMO leaves out a polygon or point with one of these in its id, with a warning.
_REFUSED_IN_IDS = " \t\n\r|\\'\";,<>&"


class ZoneSource(Protocol):
    """A simulation that can be asked for the zones that are drawn in it.

    Attributes:
        options: what it was started with.
    """

    options: SumoOptions

    def zones(self, known_keys: KeysOfTypes) -> list[DrawnZone]:
        """Return the zones; see `read_zones`."""
        ...


def read_zones(known_keys: KeysOfTypes, files: tuple[Path, ...]) -> list[DrawnZone]:
    """Ask the running simulation for the zones, in the order of their ids: the polygons, then the points.

    Args:
        known_keys: the types of zones and the parameters of each; libsumo gives no parameter without its key.
        files: the simulation's additional and route files, searched for types and keys that are not known.

    Raises:
        GpsecError: a zone has a ``gpsec.…`` type or parameter that is not in `known_keys`, a polygon is degenerate, or
            a zone that stands in the files is not in the simulation.
    """
    import libsumo  # late: only the process of SUMO reads zones

    loaded = {"poly": set(libsumo.polygon.getIDList()), "poi": set(libsumo.poi.getIDList())}
    file_of = _files_of_zones(loaded, known_keys, files)
    somewhere = ", ".join(file.name for file in files)  # of a file that only SUMO can read
    polygons = [
        DrawnZone(
            zone,
            "polygon",
            np.array(libsumo.polygon.getShape(zone), float),
            _parameters(libsumo.polygon, zone, known_keys[kind]),
            file_of.get(("poly", zone), somewhere),
            kind,
        )
        for zone in sorted(loaded["poly"])
        if (kind := libsumo.polygon.getType(zone)) in known_keys
    ]
    points = [
        DrawnZone(
            zone,
            "point",
            np.array([libsumo.poi.getPosition(zone)], float),
            _parameters(libsumo.poi, zone, known_keys[kind]),
            file_of.get(("poi", zone), somewhere),
            kind,
        )
        for zone in sorted(loaded["poi"])
        if (kind := libsumo.poi.getType(zone)) in known_keys
    ]
    for zone in polygons:
        if len(np.unique(zone.shape_m, axis=0)) < 3:
            raise GpsecError(f"{zone.where}: expected three corners or more, found {len(zone.shape_m)}")
    _refuse_unknown_keys(known_keys, files)
    return polygons + points


def _parameters(domain: Any, zone: str, known_keys: Collection[str]) -> dict[str, str]:
    values = {key: domain.getParameter(zone, key) for key in sorted(known_keys)}
    return {key: value for key, value in values.items() if value}


def _files_of_zones(
    loaded: Mapping[str, Collection[str]], kinds: Collection[str], files: tuple[Path, ...]
) -> dict[tuple[str, str], str]:
    """Return by tag and id which file each zone is drawn in.

    One of no known type, or not among those `loaded`, by tag, is refused: it would have no effect, in silence.
    """
    found: dict[tuple[str, str], str] = {}
    for file in input_files(files):
        for tag, zone_id, kind in _drawn(file):
            if kind not in kinds:
                raise GpsecError(
                    f"{file}: {tag} '{shown(zone_id)}': unknown type '{shown(kind)}': {nearest(kind, kinds)}"
                )
            if zone_id not in loaded[tag]:
                is_refused = any(sign in _REFUSED_IN_IDS for sign in zone_id)
                wanted = (
                    "an id without blanks and without | \\ ' \" ; , < > &" if is_refused else "it in an additional file"
                )
                raise GpsecError(
                    f"{file}: {tag} '{shown(zone_id)}' is of type '{kind}', but SUMO has not loaded it: "
                    f"expected {wanted}"
                )
            found.setdefault((tag, zone_id), str(file))
    return found


def _drawn(file: Path) -> Iterator[tuple[str, str, str]]:
    """Yield tag, id and type of what has a ``gpsec.…`` type in an input file."""
    try:
        if is_plain(file) and not first_match(file, rb"(gpsec|&#)"):
            return
        with open_input(file) as stream:
            for _, element in ElementTree.iterparse(stream):
                kind = element.get("type", "")
                if element.tag in ("poly", "poi") and kind.startswith(PREFIX):
                    yield element.tag, element.get("id", ""), kind
                element.clear()
    except UNREADABLE:
        return  # SUMO has said what is wrong with the file


def _refuse_unknown_keys(known_keys: KeysOfTypes, files: tuple[Path, ...]) -> None:
    for file in files:
        for found in own_parameters(file):
            if found.element in ("vType", *DEPARTING):
                continue  # what vehicles carry is looked at elsewhere
            if found.key == ATTACK_KEY and found.owner_type != ATTACK_ZONE:
                raise GpsecError(
                    f"{found.file}: {shown(found.element)} '{shown(found.owner_id)}': parameter '{shown(found.key)}': "
                    f"expected it in a poly or poi of type '{ATTACK_ZONE}', found type '{shown(found.owner_type)}'"
                )
            if found.element in ("poly", "poi") and found.owner_type in known_keys:
                keys = known_keys[found.owner_type]
                if found.key not in keys:
                    raise GpsecError(
                        f"{found.file}: zone '{shown(found.owner_id)}': unknown parameter '{shown(found.key)}': "
                        f"{nearest(found.key, keys)}"
                    )
