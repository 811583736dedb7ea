"""The options `--spoofer` and `--only-zones`: an attack at a place, without netedit and without a file."""

from collections.abc import Iterator, Sequence
from itertools import count
from typing import TYPE_CHECKING

from gpsec.core.errors import GpsecError, shown

if TYPE_CHECKING:
    from gpsec.attacks.plans import PlanConfig
    from gpsec.scenario import Scenario

_FORM = "lon,lat,radius_m[,begin,end,attack]"
_NAME, _ATTACK = "roadside", "drift"


def with_spoofers(scenario: "Scenario", texts: Sequence[str], *, only_zones: bool) -> "Scenario":
    """Return a scenario with a plan for each `--spoofer`; with `only_zones`, without the plans that have no place.

    They are called ``roadside``, ``roadside2`` and so on, and attack whoever comes near.

    Raises:
        GpsecError: a text is not of the form ``lon,lat,radius_m[,begin,end,attack]``.
    """
    plans = [plan for plan in scenario.plans if not only_zones or plan.placed or plan.zone is not None]
    taken = {plan.name for plan in scenario.plans}
    for text in texts:
        name = next(name for name in _names() if name not in taken)
        taken.add(name)
        plans.append(_plan(text, name))
    return scenario.model_copy(update={"plans": tuple(plans)})


def _names() -> Iterator[str]:
    yield _NAME
    yield from (f"{_NAME}{number}" for number in count(2))


def _plan(text: str, name: str) -> "PlanConfig":
    from gpsec.attacks.plans import plan_config

    where = f"--spoofer {shown(text)}"
    parts = [part.strip() for part in text.split(",")]
    if not 3 <= len(parts) <= 6:
        raise GpsecError(f"{where}: expected {_FORM}, found {len(parts)} values")
    numbers = [_number(part, where) for part in parts[:5]]
    lon, lat, radius_m = numbers[:3]
    if lon is None or lat is None or radius_m is None:
        raise GpsecError(f"{where}: expected {_FORM}, found an empty place or radius")
    table: dict[str, object] = {"attack": (parts[5:] or [_ATTACK])[0] or _ATTACK, "name": name, "share": 1.0}
    table |= {"at": [lon, lat], "radius_m": radius_m}
    table |= {key: value for key, value in zip(("begin_s", "end_s"), numbers[3:], strict=False) if value is not None}
    return plan_config(table, where)


def _number(text: str, where: str) -> float | None:
    try:
        return float(text) if text else None
    except ValueError:
        raise GpsecError(f"{where}: expected {_FORM}, found '{shown(text)}' in place of a number") from None
