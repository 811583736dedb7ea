"""The lateral dynamics and the reactions that can be chosen. A new one is a file and a line here."""

from collections.abc import Mapping
from typing import TypeVar

from pydantic import ValidationError

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.registry import Registry, subclass_named
from gpsec.steering.base import LateralDynamics, Reaction, SteeringPart
from gpsec.steering.driving_on import DriveOn, Handover
from gpsec.steering.second_order import SecondOrder
from gpsec.steering.stopping import PullOver, StopInLane

_Part = TypeVar("_Part", bound=SteeringPart)

DYNAMICS: Registry[type[LateralDynamics]] = Registry(
    "lateral dynamics", "gpsec.dynamics", {SecondOrder.name: SecondOrder}, subclass_named(LateralDynamics)
)
REACTIONS: Registry[type[Reaction]] = Registry(
    "reaction",
    "gpsec.reactions",
    {reaction.name: reaction for reaction in (DriveOn, Handover, StopInLane, PullOver)},
    subclass_named(Reaction),
)


def build_part(registry: Registry[type[_Part]], name: str, parameters: Mapping[str, object]) -> _Part:
    """Return the part `name` with those parameters; those that are missing keep their defaults.

    Raises:
        GpsecError: the part or a parameter is unknown, or a value is not allowed.
    """
    kind = registry[name]
    for key in parameters:
        if key not in kind.model_fields:
            raise GpsecError(f"unknown key '{shown(key)}' of '{shown(name)}': {nearest(key, kind.model_fields)}")
    try:
        return kind.model_validate(dict(parameters))
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        key, said = ".".join(map(str, detail["loc"])), detail["msg"].removeprefix("Input should be ")
        raise GpsecError(f"{key}: expected {said}, found {shown(repr(detail['input']))}") from None
