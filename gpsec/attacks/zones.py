"""Attack zones drawn in netedit: a polygon or a point with parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from gpsec.attacks.plans import MAX_TIME_S, PlanConfig, plan_config
from gpsec.attacks.registry import ATTACKS, build_attack
from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import GpsecError
from gpsec.types.constants import PREFIX
from gpsec.types.drawn_zones import (
    ATTACK_ZONE,
    DrawnZone,
    check_finite,
    check_polygon,
    number,
    prepared_polygon,
    stated,
)

NOBODY: Mapping[str, Floats] = {}
"""No vehicle carries a spoofer."""
_MAX_RADIUS_M = 1e6
PLAN_KEYS = {"begin": "begin_s", "end": "end_s", "share": "share"}


@dataclass(frozen=True, eq=False)
class Zone:
    """An area: a polygon, or what lies within `radius_m` of a point or of vehicles that carry a spoofer.

    Attributes:
        zone_id: id in the drawing, or name of the spoofer's plan.
        shape_m: (n, 2) vertices in the net's frame; one for a point, none for what moves.
        radius_m: of a point or a spoofer, None for a polygon.
        hold_s: an attack lasts this long after a vehicle was last in the area.
    """

    zone_id: str
    shape_m: Floats
    radius_m: float | None = None
    hold_s: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether it goes along with vehicles."""
        return not len(self.shape_m)

    @cached_property
    def polygon(self) -> Any:
        """The prepared shapely polygon."""
        return prepared_polygon(self.shape_m)

    def contains(self, position_m: Floats, spoofers_m: Mapping[str, Floats] = NOBODY) -> Flags:
        """Return (n,) whether the positions (n, 2) lie in the zone.

        `spoofers_m` says where those are, (k, 2), that carry the spoofers of each plan.
        """
        if self.radius_m is None:
            inside: Flags = shapely.contains_xy(self.polygon, position_m[:, 0], position_m[:, 1])
            return inside
        within: Flags = np.zeros(len(position_m), np.bool_)
        for centre_m in spoofers_m.get(self.zone_id, ()) if self.moves else self.shape_m:
            away = position_m - centre_m
            within |= np.sum(away * away, axis=1) <= self.radius_m**2
        return within


def zone_keys() -> list[str]:
    """Return every parameter that a zone may have, by its whole name."""
    own = {field for attack in ATTACKS.values() for field in attack.model_fields}
    return [PREFIX + key for key in ("attack", *PLAN_KEYS, "radius_m", *sorted(own))]


def plans_from_zones(zones: Sequence[DrawnZone]) -> list[tuple[PlanConfig, Zone, str]]:
    """Return one plan for each attack zone among `zones`, named by its id, its area, and file and zone for messages.

    Raises:
        GpsecError: a parameter is missing, unknown or not allowed, or the shape is no area.
    """
    return [(*_plan(zone, zone.where), zone.where) for zone in zones if zone.zone_type == ATTACK_ZONE]


def _plan(zone: DrawnZone, where: str) -> tuple[PlanConfig, Zone]:
    given = stated(zone.parameters)
    name = given.pop("attack", None)
    if name is None:
        raise GpsecError(f"{where}: {PREFIX}attack: expected one of {', '.join(ATTACKS)}, found none")
    area = Zone(zone.zone_id, zone.shape_m, _radius(zone.kind, given.pop("radius_m", None), where))
    _check_shape(area, where)
    others = [PREFIX + key for key in ("attack", *PLAN_KEYS, "radius_m")]
    return plan_from_text(name, given, {"name": zone.zone_id, "zone": zone.zone_id}, where, others), area


def plan_from_text(
    attack_name: str, given: dict[str, str], beside: Mapping[str, object], where: str, others: Sequence[str]
) -> PlanConfig:
    """Return the plan that parameters of one of SUMO's objects say.

    Args:
        attack_name: name of the attack.
        given: the others of its parameters, without the prefix: `PLAN_KEYS` and the attack's own.
        beside: what else is in the plan.
        where: file and object, for error messages.
        others: keys that may stand there beside the attack's own, for *did you mean*.

    Raises:
        GpsecError: a parameter is unknown or not allowed.
    """
    plan = {key: given[key] for key in PLAN_KEYS if key in given}
    own = {key: value for key, value in given.items() if key not in PLAN_KEYS}
    attack = build_attack(attack_name, own, where, prefix=PREFIX, other_keys=others, as_text=True)
    # A transmitter spares nobody, unless its share says so.
    table: dict[str, object] = {"attack": attack_name, "share": 1.0, **beside}
    table |= {PLAN_KEYS[key]: number(text, key, where) for key, text in plan.items()}
    _check_plan(table, where)
    return plan_config({**table, "parameters": attack}, where)


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
    return metres(text, where)


def metres(text: str, where: str) -> float:
    """Return the radius that the parameter ``gpsec.radius_m`` says.

    Raises:
        GpsecError: it is not above 0, or larger than any road net.
    """
    radius_m = number(text, "radius_m", where)
    if radius_m <= 0.0:
        raise GpsecError(f"{where}: {PREFIX}radius_m: expected a number greater than 0, found {radius_m:g}")
    if radius_m > _MAX_RADIUS_M:
        raise GpsecError(f"{where}: {PREFIX}radius_m: expected at most {_MAX_RADIUS_M:g} metres, found {radius_m:g}")
    return radius_m


def _check_shape(zone: Zone, where: str) -> None:
    check_finite(zone.shape_m, where)
    if zone.radius_m is None:
        check_polygon(zone.shape_m, where)
