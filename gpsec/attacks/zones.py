"""Attack zones drawn in netedit: a polygon or a point with parameters."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, Protocol

import numpy as np
import shapely

from gpsec.arrays import Flags, Floats
from gpsec.attacks.plans import MAX_TIME_S, PlanConfig, plan_config
from gpsec.attacks.registry import ATTACKS, build_attack
from gpsec.errors import GpsecError

PREFIX = "gpsec."
_MAX_RADIUS_M = 1e6
_PLAN_KEYS = {"begin": "begin_s", "end": "end_s", "share": "share"}


class DrawnZone(Protocol):
    """What the traffic source hands over.

    Attributes:
        zone_id: id of the polygon or point.
        kind: "polygon" or "point".
        shape_m: (n, 2) vertices in the net's frame; one for a point.
        parameters: its ``gpsec.…`` parameters by their whole names; an empty value is as good as none.
    """

    @property
    def zone_id(self) -> str: ...  # noqa: D102
    @property
    def kind(self) -> str: ...  # noqa: D102
    @property
    def shape_m(self) -> Floats: ...  # noqa: D102
    @property
    def parameters(self) -> dict[str, str]: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Zone:
    """An area: a polygon, or what lies within `radius_m` of a point.

    Attributes:
        zone_id: id in the drawing.
        shape_m: (n, 2) vertices in the net's frame; one for a point.
        radius_m: of a point, None for a polygon.
    """

    zone_id: str
    shape_m: Floats
    radius_m: float | None = None

    @cached_property
    def polygon(self) -> Any:
        """The prepared shapely polygon."""
        polygon = shapely.Polygon(self.shape_m)
        shapely.prepare(polygon)
        return polygon

    def contains(self, position_m: Floats) -> Flags:
        """Return (n,) whether the positions (n, 2) lie in the zone."""
        if self.radius_m is None:
            inside: Flags = shapely.contains_xy(self.polygon, position_m[:, 0], position_m[:, 1])
            return inside
        away = position_m - self.shape_m[0]
        within: Flags = np.sum(away * away, axis=1) <= self.radius_m**2
        return within


def zone_keys() -> list[str]:
    """Return every parameter that a zone may have, by its whole name."""
    own = {field for attack in ATTACKS.values() for field in attack.model_fields}
    return [PREFIX + key for key in ("attack", *_PLAN_KEYS, "radius_m", *sorted(own))]


def plans_from_zones(zones: Sequence[DrawnZone], file: str) -> list[tuple[PlanConfig, Zone]]:
    """Return one plan a zone, named by the zone's id.

    Raises:
        GpsecError: a parameter is missing, unknown or not allowed, or the shape is no area.
    """
    return [_plan(zone, f"{file}: zone '{zone.zone_id}'") for zone in zones]


def _plan(zone: DrawnZone, where: str) -> tuple[PlanConfig, Zone]:
    given = {
        key.removeprefix(PREFIX): value
        for key, value in zone.parameters.items()
        if key.startswith(PREFIX) and value.strip()
    }
    name = given.pop("attack", None)
    if name is None:
        raise GpsecError(f"{where}: {PREFIX}attack: expected one of {', '.join(ATTACKS)}, found none")
    area = Zone(zone.zone_id, zone.shape_m, _radius(zone.kind, given.pop("radius_m", None), where))
    _check_shape(area, where)
    plan = {key: given.pop(key) for key in _PLAN_KEYS if key in given}
    others = [PREFIX + key for key in ("attack", *_PLAN_KEYS, "radius_m")]
    attack = build_attack(name, given, where, prefix=PREFIX, other_keys=others, as_text=True)
    # A transmitter spares nobody, unless its share says so.
    table: dict[str, object] = {"attack": name, "name": zone.zone_id, "zone": zone.zone_id, "share": 1.0}
    table |= {_PLAN_KEYS[key]: _number(text, key, where) for key, text in plan.items()}
    _check_plan(table, where)
    return plan_config({**table, "parameters": attack.model_dump()}, where), area


def _number(text: str, key: str, where: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not isfinite(number):
        raise GpsecError(f"{where}: {PREFIX}{key}: expected a number, found '{text}'")
    return number


def _check_plan(table: dict[str, object], where: str) -> None:
    share, begin_s, end_s = (table.get(key) for key in ("share", "begin_s", "end_s"))
    if isinstance(share, float) and not 0.0 <= share <= 1.0:
        raise GpsecError(f"{where}: {PREFIX}share: expected a number from 0 to 1, found {share:g}")
    for key, time_s in (("begin", begin_s), ("end", end_s)):
        if isinstance(time_s, float) and not 0.0 <= time_s <= MAX_TIME_S:
            raise GpsecError(f"{where}: {PREFIX}{key}: expected seconds from 0 to {MAX_TIME_S:g}, found {time_s:g}")
    begin_s = begin_s if isinstance(begin_s, float) else 0.0
    if isinstance(end_s, float) and end_s <= begin_s:
        raise GpsecError(f"{where}: {PREFIX}end: expected later than {PREFIX}begin = {begin_s:g}, found {end_s:g}")


def _radius(kind: str, text: str | None, where: str) -> float | None:
    if kind == "polygon":
        if text is not None:
            raise GpsecError(
                f"{where}: {PREFIX}radius_m: expected none for a polygon (only points have it), found {text}"
            )
        return None
    if text is None:
        raise GpsecError(f"{where}: {PREFIX}radius_m: expected a number of metres for a point, found none")
    radius_m = _number(text, "radius_m", where)
    if radius_m <= 0.0:
        raise GpsecError(f"{where}: {PREFIX}radius_m: expected a number greater than 0, found {radius_m:g}")
    if radius_m > _MAX_RADIUS_M:
        raise GpsecError(f"{where}: {PREFIX}radius_m: expected at most {_MAX_RADIUS_M:g} metres, found {radius_m:g}")
    return radius_m


def _check_shape(zone: Zone, where: str) -> None:
    if not np.isfinite(zone.shape_m).all():
        raise GpsecError(f"{where}: shape: expected finite coordinates, found {zone.shape_m.tolist()}")
    if zone.radius_m is not None:
        return
    corners = len(np.unique(zone.shape_m, axis=0))
    if corners < 3:
        raise GpsecError(f"{where}: shape: expected a polygon of at least 3 corners, found {corners}")
    if not zone.polygon.is_valid:
        reason = shapely.is_valid_reason(zone.polygon)
        raise GpsecError(f"{where}: shape: expected a polygon that does not cross itself, found {reason}")
