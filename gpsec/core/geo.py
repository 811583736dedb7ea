"""Frames and units: SUMO heading and yaw, the net's metric frame and WGS84."""

from dataclasses import dataclass, field
from functools import cached_property
from math import cos, floor, pi, radians, sin
from typing import TYPE_CHECKING

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, retold, shown
from gpsec.core.kernels import inline

if TYPE_CHECKING:
    import pyproj

# A net without a projection gets this origin (longitude, latitude): Braunschweig, the home of SUMO.
DEFAULT_ORIGIN_DEG = (10.5268, 52.2647)


def yaw_from_sumo_angle(angle_deg: float) -> float:
    """Return yaw in radians, counter-clockwise from east, of SUMO's angle in degrees, clockwise from north."""
    return _wrap(radians(90.0 - angle_deg))


def _wrap(angle_rad: float) -> float:
    """Return the same direction in [-pi, pi)."""
    return angle_rad - 2.0 * pi * floor((angle_rad + pi) / (2.0 * pi))


wrap_angle = inline(_wrap)


@inline
def dead_reckon(x_m: float, y_m: float, yaw_rad: float, distance_m: float, turn_rad: float) -> tuple[float, float]:
    """Return the position after a circular arc of length `distance_m` that turns by `turn_rad`.

    The chord of an arc points along yaw + turn/2 and is distance·sinc(turn/2) long: exact for a constant turn rate.
    """
    half = 0.5 * turn_rad
    sinc = 1.0 - half * half / 6.0 * (1.0 - half * half / 20.0) if abs(half) < 1e-2 else sin(half) / half
    chord = distance_m * sinc
    return x_m + chord * cos(yaw_rad + half), y_m + chord * sin(yaw_rad + half)


@dataclass(frozen=True)
class Projector:
    """Converts between a net's metric frame and WGS84.

    Attributes:
        definition: PROJ string of the net's ``<location projParameter>``, or "!" or "-" where it has none.
        offset_m: the net's ``netOffset``: net = projected + offset.
        source: file that it came from, for error messages.
    """

    definition: str
    offset_m: tuple[float, float] = (0.0, 0.0)
    source: str = field(default="net", compare=False)

    @property
    def has_projection(self) -> bool:
        """The net itself says where on the Earth it lies."""
        return self.definition not in {"!", "-", "."}

    @cached_property
    def _transformer(self) -> "pyproj.Transformer":
        import pyproj  # late: hardly any run asks for longitudes

        lon, lat = DEFAULT_ORIGIN_DEG
        fallback = f"+proj=tmerc +lat_0={lat} +lon_0={lon} +datum=WGS84 +units=m"
        try:
            projected = pyproj.CRS(self.definition if self.has_projection else fallback)
            return pyproj.Transformer.from_crs("EPSG:4326", projected, always_xy=True)
        except pyproj.exceptions.ProjError as error:
            raise GpsecError(
                f"{self.source}: location projParameter '{shown(self.definition)}' is no projection that PROJ knows"
                f" ({retold(str(error))})"
            ) from None

    @property
    def _shift(self) -> Floats:
        return np.asarray(self.offset_m if self.has_projection else (0.0, 0.0))

    def to_lon_lat(self, position_m: Floats) -> Floats:
        """Return (…, 2) longitude and latitude in degrees of (…, 2) positions in the net's frame."""
        projected = position_m - self._shift
        lon, lat = self._transformer.transform(projected[..., 0], projected[..., 1], direction="INVERSE")
        return np.stack([lon, lat], axis=-1)

    def from_lon_lat(self, lon_lat_deg: Floats) -> Floats:
        """Return (…, 2) positions in the net's frame of (…, 2) longitudes and latitudes in degrees."""
        x, y = self._transformer.transform(lon_lat_deg[..., 0], lon_lat_deg[..., 1])
        return np.stack([x, y], axis=-1) + self._shift
