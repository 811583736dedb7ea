"""Areas that a user has drawn in netedit, and their parameters."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, Literal

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.types.constants import PREFIX

ATTACK_ZONE, MULTIPATH_ZONE = f"{PREFIX}attack", f"{PREFIX}multipath"
"""Types of polygons (and points) that mean something to gpsec."""


@dataclass(frozen=True)
class DrawnZone:
    """A zone as it was drawn.

    Attributes:
        zone_id: id of the polygon or point.
        kind: ``polygon`` or ``point``.
        shape_m: (n, 2) corners in the net's frame; one row for a point.
        parameters: the ``gpsec.…`` parameters that it has, with the prefix.
        file: that it is drawn in.
        zone_type: what it is for.
    """

    zone_id: str
    kind: Literal["polygon", "point"]
    shape_m: Floats
    parameters: dict[str, str]
    file: str
    zone_type: str = ATTACK_ZONE

    @property
    def where(self) -> str:
        """File and zone, for error messages."""
        return f"{self.file}: zone '{shown(self.zone_id)}'"


def stated(parameters: Mapping[str, str]) -> dict[str, str]:
    """Return the ``gpsec.…`` parameters that have a value, without the prefix."""
    return {
        key.removeprefix(PREFIX): value for key, value in parameters.items() if key.startswith(PREFIX) and value.strip()
    }


def number(text: str, key: str, where: str) -> float:
    """Return what the parameter `key`, named without its prefix, says.

    Raises:
        GpsecError: it is no finite number.
    """
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise GpsecError(f"{where}: {PREFIX}{key}: expected a number, found '{shown(text)}'")
    return value


def prepared_polygon(shape_m: Floats) -> Any:
    """Return the shapely polygon of (n, 2) corners, prepared for many questions."""
    import shapely  # late, here and below: the process of SUMO reads zones, and asks nothing of them

    polygon = shapely.Polygon(shape_m)
    shapely.prepare(polygon)
    return polygon


def check_finite(shape_m: Floats, where: str) -> None:
    """Refuse corners that are nowhere.

    Raises:
        GpsecError: a coordinate is not finite.
    """
    if not np.isfinite(shape_m).all():
        raise GpsecError(f"{where}: shape: expected finite coordinates, found {shape_m.tolist()}")


def check_polygon(shape_m: Floats, where: str) -> None:
    """Refuse a polygon without an area.

    Raises:
        GpsecError: it has fewer than three corners, or crosses itself.
    """
    corners = len(np.unique(shape_m, axis=0))
    if corners < 3:
        raise GpsecError(f"{where}: shape: expected a polygon of at least 3 corners, found {corners}")
    import shapely

    polygon = shapely.Polygon(shape_m)
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon)
        raise GpsecError(f"{where}: shape: expected a polygon that does not cross itself, found {reason}")
