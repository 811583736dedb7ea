"""What a user says of an attack plan: who is attacked, when, and how."""

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    SerializeAsAny,
    Strict,
    ValidationError,
    WithJsonSchema,
    model_validator,
)

from gpsec.attacks.base import Attack
from gpsec.attacks.registry import ATTACKS, build_attack, first_problem
from gpsec.core.errors import GpsecError, shown

NO_ATTACK = "none"
"""Name of plan 0, under which nobody is attacked."""

MAX_TIME_S = 1e7
"""Longest time that can be said, some 116 days: steps have to be numbered."""


def _seconds(value: object) -> tuple[float, float]:
    pair = tuple(value) if isinstance(value, list | tuple) else ()
    numbers = [x for x in pair if isinstance(x, int | float) and not isinstance(x, bool)]
    if len(pair) != 2 or len(numbers) != 2 or not 0.0 <= numbers[0] <= numbers[1]:
        raise ValueError(f"expected [least, most] in seconds with 0 <= least <= most, found {str(value)[:60]}")
    if numbers[1] > MAX_TIME_S:
        raise ValueError(f"expected [least, most] in seconds up to {MAX_TIME_S:g}, found {str(numbers[1])[:60]}")
    return float(numbers[0]), float(numbers[1])


def _lon_lat(value: object) -> tuple[float, float]:
    pair = tuple(value) if isinstance(value, list | tuple) else ()
    numbers = [x for x in pair if isinstance(x, int | float) and not isinstance(x, bool)]
    if len(pair) != 2 or len(numbers) != 2 or not (abs(numbers[0]) <= 180.0 and abs(numbers[1]) <= 90.0):
        raise ValueError(f"expected [longitude, latitude] in degrees, found {str(value)[:60]}")
    return float(numbers[0]), float(numbers[1])


_TABLE = {"additionalProperties": True, "default": {}, "title": "Parameters", "type": "object"}
Seconds = Annotated[tuple[float, float], BeforeValidator(_seconds)]
LonLat = Annotated[tuple[float, float], BeforeValidator(_lon_lat)]
Number = Annotated[float, Strict()]
Text = Annotated[str, Strict()]


class PlanConfig(BaseModel):
    """One attack plan. In TOML the attack's own parameters stand beside these keys, or in a table `parameters`.

    A vehicle is attacked at most once under a plan. Who is attacked and when is drawn from the run's seed and
    the vehicle alone: plans with equal settings attack the same vehicles in the same windows. Once it is read,
    `parameters` is the attack itself.

    Attributes:
        attack: what is done (`gpsec list attacks`).
        name: of the plan, in every table, and no two plans have the same; unset takes the attack's.
        share: of the equipped vehicles (of those types and ids) that is attacked; of those who come into a zone, where
            one is named.
        vehicle_types: ids of SUMO's vehicle types that are attacked; empty for all.
        vehicles: ids of the vehicles that are attacked, `*` for any text and `?` for any letter; a flow's vehicles are
            `flow.*`; empty for all.
        zone: id of a drawn zone, or of a spoofer that follows traffic; the attack then lasts from when a vehicle is in
            it until it leaves it, and `start_after_s` and `duration_s` have no meaning.
        at: longitude and latitude of a spoofer that stands by the road: who comes within `radius_m` of it is attacked,
            as in a zone.
        edge: SUMO's edge in the middle of which it stands, instead of `at`.
        radius_m: reach of a spoofer `at` a place or on an `edge`.
        begin_s: simulated time before which no attack begins.
        end_s: simulated time at which all attacks end.
        start_after_s: least and most seconds from when a vehicle has settled (and `begin_s` has passed) to its attack.
        duration_s: least and most seconds that an attack lasts.
        parameters: the attack's own keys, where they are not to stand beside these.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    attack: Text
    name: Annotated[Text, Field(min_length=1)] = ""
    share: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.5
    vehicle_types: tuple[Text, ...] = ()
    vehicles: tuple[Text, ...] = ()
    zone: Text | None = None
    at: LonLat | None = None
    edge: Text | None = None
    radius_m: Annotated[Number, Field(gt=0.0, le=1e6)] | None = None
    begin_s: Annotated[Number, Field(ge=0.0, le=MAX_TIME_S)] = 0.0
    end_s: Annotated[Number, Field(ge=0.0, le=MAX_TIME_S)] | None = None
    start_after_s: Seconds = (0.0, 30.0)
    duration_s: Seconds = (10.0, 30.0)
    parameters: Annotated[SerializeAsAny[Attack], WithJsonSchema(_TABLE)] = Field(default_factory=Attack)

    @property
    def placed(self) -> bool:
        """Whether it names the place of a spoofer itself."""
        return self.at is not None or self.edge is not None

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, table: object) -> object:
        """Make the attack of its own keys, and put it in their place."""
        if not isinstance(table, Mapping) or not isinstance(table.get("attack"), str):
            return table
        own = {key: value for key, value in table.items() if key in cls.model_fields}
        nested = own.get("parameters", {})
        beside = {key: value for key, value in table.items() if key not in cls.model_fields}
        if isinstance(nested, Attack) and nested.name == own["attack"] and not beside:
            return {"name": nested.name, **own}
        if not isinstance(nested, Mapping):
            raise ValueError(f"parameters: expected a table, found {shown(repr(nested))}")
        twice = sorted(set(beside) & set(nested))
        if twice:
            raise ValueError(f"key '{shown(twice[0])}' stands in the plan and in its parameters")
        attack = _attack(own["attack"], {**nested, **beside})
        return {"name": attack.name, **own, "parameters": attack}

    @model_validator(mode="after")
    def _agree(self) -> Self:
        """Check what several keys say together."""
        if self.name == NO_ATTACK:
            raise ValueError(f"name: '{NO_ATTACK}' is kept for vehicles without an attack")
        if self.end_s is not None and self.end_s <= self.begin_s:
            raise ValueError(f"end_s: expected later than begin_s = {self.begin_s:g}, found {self.end_s:g}")
        places = [key for key in ("zone", "at", "edge") if getattr(self, key) is not None]
        if len(places) > 1:
            raise ValueError(f"{places[1]}: expected one place, found `{places[0]}` beside it")
        if self.placed != (self.radius_m is not None):
            here = "none without `at` or `edge`" if self.radius_m is not None else "the reach of the spoofer, in metres"
            raise ValueError(f"radius_m: expected {here}, found {self.radius_m or 'none'}")
        for key in ("start_after_s", "duration_s"):
            if places and getattr(self, key) != type(self).model_fields[key].default:
                beside = "a zone" if self.zone is not None else "the place of a spoofer"
                raise ValueError(f"{key}: expected none beside {beside}, which says when an attack begins and ends")
        return self


def _attack(name: str, parameters: Mapping[str, object]) -> Attack:
    keys = [key for key in PlanConfig.model_fields if key != "parameters"]
    try:
        return build_attack(name, parameters, "", other_keys=keys)
    except GpsecError as error:
        raise ValueError(str(error).removeprefix(": ")) from None


def plan_config(table: Mapping[str, object], where: str) -> PlanConfig:
    """Return the plan that a table says.

    Args:
        table: keys and values, as in a ``[[plans]]`` table of TOML.
        where: file and key of the table, for error messages.

    Raises:
        GpsecError: something in it is missing, unknown or not allowed.
    """
    if "attack" not in table:
        raise GpsecError(f"{where}: attack: expected one of {', '.join(ATTACKS)}, found none")
    try:
        return PlanConfig.model_validate(dict(table))
    except ValidationError as error:
        raise GpsecError(f"{where}: {first_problem(error)}") from None
