"""The section `[closed_loop]`: which worlds are run, and how vehicles in them steer, react and crash."""

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from gpsec.core.errors import GpsecError
from gpsec.scenario import choices
from gpsec.scenario.base import Section, Unset
from gpsec.types.constants import UNDEFENDED

# Who steers still later leaves the road by the delay alone.
MOST_DELAY_S = 2.0
# Plan of a world without an attack, and the reaction that changes nothing.
BENIGN, DRIVE_ON = "none", "continue"


class ClosedWorld(Section):
    """Traffic in which one plan attacks and one defence steers.

    Attributes:
        plan: name of the attack plan; `none` attacks nobody.
        defence: name of the defence whose estimate steers, and whose alarm is reacted to; the others look on.
        on_alarm: see `closed_loop.on_alarm`; unset takes that.
        false_alarms_per_h: alarms for no reason that are added to those of the detector, in a vehicle-hour.
    """

    plan: str = BENIGN
    defence: str = UNDEFENDED
    on_alarm: Annotated[str | None, Unset] = None
    false_alarms_per_h: float = Field(0.0, ge=0.0, le=3600.0)

    @field_validator("on_alarm")
    @classmethod
    def _known_reaction(cls, name: str | None) -> str | None:
        return None if name is None else choices.require_known("reaction", name, choices.reactions())


class ClosedLoopSection(Section):
    """Vehicles that steer by their estimate, in `gpsec run --closed-loop`.

    Attributes:
        worlds: those that are run, each a table with `plan`, `defence` and `on_alarm`; to each belongs a benign twin,
            which is added. Unset takes the first plan, undefended and with the last defence.
        seeds: runs of each world; three are a first look, claims need ten.
        steer: who steers by the estimate: `attacked` vehicles, or `all`, which honest errors move as well.
        on_alarm: what a vehicle does on an alarm (`gpsec list reactions`).
        reaction_parameters: keys of that reaction that change.
        dynamics: how a vehicle moves across the road (`gpsec list dynamics`).
        dynamics_parameters: keys of these that change.
        delay_s: from an estimate to the steering that goes by it, beyond the 0.1 s that every command takes.
        oncoming_reaction_s: seconds until a driver brakes for who comes at them; 1.5 s is usual where one is surprised
            (Green, 2000, doi 10.1207/STHF0203_1).
        oncoming_decel_mps2: of that braking.
        wreck_s: seconds for which a wreck stands before it is taken away.
        off_road: what a vehicle does that is off the road: `stop`, or `continue`.
        world: set by gpsec itself: the one that is run.
    """

    worlds: tuple[ClosedWorld, ...] = Field((), strict=False)
    seeds: int = Field(10, ge=1, le=1000)
    steer: Literal["attacked", "all"] = "attacked"
    on_alarm: str = DRIVE_ON
    reaction_parameters: Mapping[str, float] = Field({})
    dynamics: str = "second_order"
    dynamics_parameters: Mapping[str, float] = Field({})
    delay_s: float = Field(0.0, ge=0.0, le=MOST_DELAY_S)
    oncoming_reaction_s: float = Field(1.5, ge=0.0, le=60.0)
    oncoming_decel_mps2: float = Field(6.0, gt=0.0, le=9.0)
    wreck_s: float = Field(600.0, ge=0.0, le=86_400.0)
    off_road: Literal["stop", "continue"] = "stop"
    world: Annotated[ClosedWorld | None, Unset] = None

    @field_validator("on_alarm")
    @classmethod
    def _known_reaction(cls, name: str) -> str:
        return choices.require_known("reaction", name, choices.reactions())

    @field_validator("dynamics")
    @classmethod
    def _known_dynamics(cls, name: str) -> str:
        return choices.require_known("lateral dynamics", name, choices.dynamics())

    @model_validator(mode="after")
    def _parameters_are_known(self) -> Self:
        try:
            choices.check_steering(self.on_alarm, self.reaction_parameters, self.dynamics, self.dynamics_parameters)
        except GpsecError as error:
            raise ValueError(str(error)) from None
        return self


def reactions_of(section: ClosedLoopSection) -> list[str]:
    """Return the names of the reactions that the section and its worlds have."""
    worlds = [*section.worlds, *([] if section.world is None else [section.world])]
    return list(dict.fromkeys([section.on_alarm, *(world.on_alarm for world in worlds if world.on_alarm)]))
