"""Attack zones that a user has drawn in netedit: polygons and points of type ``gpsec.attack``."""

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
from gpsec.types.attack_inputs import ATTACK_KEY, DrawnZone

ZONE_TYPE = "gpsec.attack"
# SUMO leaves out a polygon or point with one of these in its id, with a warning.
_REFUSED_IN_IDS = " \t\n\r|\\'\";,<>&"


class ZoneSource(Protocol):
    """A simulation that can be asked for the zones that are drawn in it.

    Attributes:
        options: what it was started with.
    """

    options: SumoOptions

    def zones(self, known_keys: Collection[str]) -> list[DrawnZone]:
        """Return the zones; see `read_zones`."""
        ...


def read_zones(known_keys: Collection[str], files: tuple[Path, ...]) -> list[DrawnZone]:
    """Ask the running simulation for the zones, in the order of their ids.

    Args:
        known_keys: the parameters, with the prefix, that a zone may have; libsumo gives none without its key.
        files: the simulation's additional and route files, searched for keys that are not known.

    Raises:
        GpsecError: a zone has a ``gpsec.…`` parameter that is not in `known_keys`, a polygon is degenerate, or a zone
            that stands in the files is not in the simulation.
    """
    import libsumo  # late: only the process of SUMO reads zones

    loaded = {"poly": set(libsumo.polygon.getIDList()), "poi": set(libsumo.poi.getIDList())}
    _refuse_lost(loaded, files)
    polygons = [
        DrawnZone(
            zone,
            "polygon",
            np.array(libsumo.polygon.getShape(zone), float),
            _parameters(libsumo.polygon, zone, known_keys),
        )
        for zone in sorted(loaded["poly"])
        if libsumo.polygon.getType(zone) == ZONE_TYPE
    ]
    points = [
        DrawnZone(
            zone, "point", np.array([libsumo.poi.getPosition(zone)], float), _parameters(libsumo.poi, zone, known_keys)
        )
        for zone in sorted(loaded["poi"])
        if libsumo.poi.getType(zone) == ZONE_TYPE
    ]
    for zone in polygons:
        if len(np.unique(zone.shape_m, axis=0)) < 3:
            names = ", ".join(file.name for file in files)
            found = len(zone.shape_m)
            raise GpsecError(f"{names}: zone '{shown(zone.zone_id)}': expected three corners or more, found {found}")
    _refuse_unknown_keys(known_keys, files)
    return polygons + points


def _parameters(domain: Any, zone: str, known_keys: Collection[str]) -> dict[str, str]:
    values = {key: domain.getParameter(zone, key) for key in sorted(known_keys)}
    return {key: value for key, value in values.items() if value}


def _refuse_lost(loaded: Mapping[str, Collection[str]], files: tuple[Path, ...]) -> None:
    """Refuse a zone in the files that is not among those `loaded`, by tag: there would be no attack, in silence."""
    for file in input_files(files):
        for tag, zone_id in _drawn(file):
            if zone_id not in loaded[tag]:
                is_refused = any(sign in _REFUSED_IN_IDS for sign in zone_id)
                wanted = (
                    "an id without blanks and without | \\ ' \" ; , < > &" if is_refused else "it in an additional file"
                )
                raise GpsecError(
                    f"{file}: {tag} '{shown(zone_id)}' is of type '{ZONE_TYPE}', but SUMO has not loaded it: "
                    f"expected {wanted}"
                )


def _drawn(file: Path) -> Iterator[tuple[str, str]]:
    """Yield tag and id of the zones in an input file."""
    try:
        if is_plain(file) and not first_match(file, rb"(gpsec|&#)"):
            return
        with open_input(file) as stream:
            for _, element in ElementTree.iterparse(stream):
                if element.tag in ("poly", "poi") and element.get("type") == ZONE_TYPE:
                    yield element.tag, element.get("id", "")
                element.clear()
    except UNREADABLE:
        return  # SUMO has said what is wrong with the file


def _refuse_unknown_keys(known_keys: Collection[str], files: tuple[Path, ...]) -> None:
    for file in files:
        for found in own_parameters(file):
            if found.element in ("vType", *DEPARTING):
                continue  # what vehicles carry is looked at elsewhere
            if found.key == ATTACK_KEY and found.owner_type != ZONE_TYPE:
                raise GpsecError(
                    f"{found.file}: {shown(found.element)} '{shown(found.owner_id)}': parameter '{shown(found.key)}': "
                    f"expected it in a poly or poi of type '{ZONE_TYPE}', found type '{shown(found.owner_type)}'"
                )
            if found.element in ("poly", "poi") and found.owner_type == ZONE_TYPE and found.key not in known_keys:
                raise GpsecError(
                    f"{found.file}: zone '{shown(found.owner_id)}': unknown parameter '{shown(found.key)}': "
                    f"{nearest(found.key, known_keys)}"
                )
