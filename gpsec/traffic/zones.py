"""Attack zones that a user has drawn in netedit: polygons and points of type ``gpsec.attack``."""

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np

from gpsec.arrays import Floats
from gpsec.errors import GpsecError, nearest, shown
from gpsec.traffic.carried import ATTACK_KEY, DEPARTING
from gpsec.traffic.inputs import own_parameters
from gpsec.traffic.options import SumoOptions

ZONE_TYPE = "gpsec.attack"


@dataclass(frozen=True)
class ZoneShape:
    """A zone as it was drawn.

    Attributes:
        zone_id: id of the polygon or point.
        kind: ``polygon`` or ``point``.
        shape_m: (n, 2) corners in the net's frame; one row for a point.
        parameters: the ``gpsec.…`` parameters that it has, with the prefix.
    """

    zone_id: str
    kind: Literal["polygon", "point"]
    shape_m: Floats
    parameters: dict[str, str]


class ZoneSource(Protocol):
    """A simulation that can be asked for the zones that are drawn in it.

    Attributes:
        options: what it was started with.
    """

    options: SumoOptions

    def zones(self, known_keys: Collection[str]) -> list[ZoneShape]:
        """Return the zones; see `read_zones`."""
        ...


def read_zones(known_keys: Collection[str], files: tuple[Path, ...]) -> list[ZoneShape]:
    """Ask the running simulation for the zones, in the order of their ids.

    Args:
        known_keys: the parameters, with the prefix, that a zone may have; libsumo gives none without its key.
        files: the simulation's additional and route files, searched for keys that are not known.

    Raises:
        GpsecError: a zone has a ``gpsec.…`` parameter that is not in `known_keys`, or a polygon is degenerate.
    """
    import libsumo  # late: only the process of SUMO reads zones

    polygons = [
        ZoneShape(
            zone,
            "polygon",
            np.array(libsumo.polygon.getShape(zone), float),
            _parameters(libsumo.polygon, zone, known_keys),
        )
        for zone in sorted(libsumo.polygon.getIDList())
        if libsumo.polygon.getType(zone) == ZONE_TYPE
    ]
    points = [
        ZoneShape(
            zone, "point", np.array([libsumo.poi.getPosition(zone)], float), _parameters(libsumo.poi, zone, known_keys)
        )
        for zone in sorted(libsumo.poi.getIDList())
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
