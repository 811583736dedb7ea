"""Plans that vehicles carry: a spoofer that follows traffic, or a vehicle that is attacked by itself."""

from collections.abc import Sequence

import numpy as np

from gpsec.attacks.plans import MAX_TIME_S, PlanConfig
from gpsec.attacks.registry import ATTACKS
from gpsec.attacks.zones import PLAN_KEYS, Zone, metres, plan_from_text
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.types.attack_inputs import CarriedAttack
from gpsec.types.constants import PREFIX
from gpsec.types.drawn_zones import number, stated

# A car that follows its victim reached 40 to 50 m with a portable spoofer (Zeng et al., "All Your GPS Are Belong To
# Us", USENIX Security 2018).
SPOOFER_REACH_M = 45.0
# Assumed: a receiver keeps to a signal that it has locked to for a while, and traffic drifts in and out of range.
SPOOFER_HOLD_S = 3.0
_MAX_HOLD_S = 600.0
_MOVING_KEYS = ("radius_m", "hold_s")


def plans_from_vehicles(carried: Sequence[CarriedAttack]) -> list[tuple[PlanConfig, Zone | None, str]]:
    """Return the plans that vehicles carry, each with the area about its spoofers (None without) and its place.

    What states the same plan is one plan, and must say the same.

    Raises:
        GpsecError: a parameter is missing, unknown or not allowed, or a plan is not the same everywhere.
    """
    groups: dict[tuple[str, str], list[CarriedAttack]] = {}
    for attack in carried:
        # One that does not state its plan is alone; two of the same id are refused when plans are gathered.
        groups.setdefault((attack.plan, "" if attack.states_plan else attack.where), []).append(attack)
    return [_plan(members) for members in groups.values()]


def _plan(members: Sequence[CarriedAttack]) -> tuple[PlanConfig, Zone | None, str]:
    first = members[0]
    for other in members[1:]:
        _check_same(first, other)
    where, given = first.where, stated(first.parameters)
    given.pop("plan", None)
    name = given.pop("attack", None)
    if name is None:
        raise GpsecError(f"{where}: {PREFIX}attack: expected one of {', '.join(ATTACKS)}, found none")
    if name not in ATTACKS:
        raise GpsecError(f"{where}: {PREFIX}attack: unknown attack '{shown(name)}': {nearest(name, ATTACKS)}")
    others = [PREFIX + key for key in ("attack", "plan", *PLAN_KEYS, *_MOVING_KEYS)]
    if first.transmits:
        radius_m = metres(given.pop("radius_m", f"{SPOOFER_REACH_M}"), where)
        hold_s = _hold_s(given.pop("hold_s", f"{SPOOFER_HOLD_S}"), where)
        config = plan_from_text(name, given, {"name": first.plan, "zone": first.plan}, where, others)
        return config, Zone(first.plan, np.zeros((0, 2)), radius_m, hold_s), where
    whole_journey = {
        "name": first.plan,
        "vehicles": [member.vehicles for member in members],
        "start_after_s": [0.0, 0.0],
        "duration_s": [MAX_TIME_S, MAX_TIME_S],
    }
    return plan_from_text(name, given, whole_journey, where, others), None, where


def _check_same(first: CarriedAttack, other: CarriedAttack) -> None:
    if first.transmits != other.transmits:
        raise GpsecError(
            f"{other.where}: {PREFIX}plan: expected a plan of its own, found '{shown(other.plan)}' of {first.where}: "
            "one of the two is a spoofer and the other one is attacked"
        )
    one, two = stated(first.parameters), stated(other.parameters)
    for key in sorted(one.keys() | two.keys()):
        if one.get(key) != two.get(key):
            raise GpsecError(
                f"{other.where}: {PREFIX}{key}: expected the same as in {first.where} of the same plan "
                f"'{shown(first.plan)}', {_said(one.get(key))}, found {_said(two.get(key))}"
            )


def _said(value: str | None) -> str:
    return "none" if value is None else f"'{shown(value)}'"


def _hold_s(text: str, where: str) -> float:
    hold_s = number(text, "hold_s", where)
    if not 0.0 <= hold_s <= _MAX_HOLD_S:
        raise GpsecError(f"{where}: {PREFIX}hold_s: expected seconds from 0 to {_MAX_HOLD_S:g}, found {hold_s:g}")
    return hold_s
