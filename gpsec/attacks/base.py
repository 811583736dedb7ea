"""What every attack shares: its parameters are a frozen model, its formula works on arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from gpsec import noise
from gpsec.arrays import Flags, Floats, Ints, Keys
from gpsec.fleet import Rows


@dataclass(frozen=True)
class Victims:
    """The tracks of one plan whose attack is active in this step; m of them.

    The attacker is taken to know where the road lies (its map) and what an undefended victim believes; it
    knows nothing of detectors.

    Attributes:
        rows: (m,) track rows, for the attack's own state.
        key: (m,) the vehicle's key for counter-based noise.
        step: step of the loop; step_s: its length.
        elapsed_s: (m,) since the attack on this vehicle began, 0 in its first step.
        fix_m: (m, 2) honest GNSS fix in the net's frame; fix_valid: (m,) there is one in this step.
        lane_yaw_rad: (m,) direction of the lane at the vehicle.
        lane_width_m: (m,) of that lane.
        left_lane, right_lane: (m,) there is a lane of either direction beside it on that side.
        deviation_m: (m,) cross-track error of the undefended estimate after the last step, left positive.
        past_fix: past_fix(delay_s) gives (m, 2) honest fixes of that long ago and (m,) whether they exist.
    """

    rows: Ints
    key: Keys
    step: int
    step_s: float
    elapsed_s: Floats
    fix_m: Floats
    fix_valid: Flags
    lane_yaw_rad: Floats
    lane_width_m: Floats
    left_lane: Flags
    right_lane: Flags
    deviation_m: Floats
    past_fix: Callable[[float], tuple[Floats, Flags]]


@dataclass(frozen=True)
class Spoofed:
    """Fixes after an attack: fix_m (m, 2) and whether there is one, valid (m,)."""

    fix_m: Floats
    valid: Flags


class NoState(Rows):
    """State of an attack that needs none."""

    def __post_init__(self) -> None:
        self._blank = {}

    def _arrays(self) -> list[tuple[str, np.ndarray]]:
        return []


class Attack(BaseModel):
    """A way to falsify GNSS fixes. The fields of a subclass are its parameters, with units and bounds.

    A subclass states its `name` and writes `spoof`, the formula; it may keep a state of arrays per track.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")
    name: ClassVar[str]

    def needed_memory_s(self) -> float:
        """Return how far back `Victims.past_fix` must reach."""
        return 0.0

    def new_state(self, capacity: int) -> Rows:
        """Return the attack's own arrays for `capacity` track rows."""
        return NoState()

    def spoof(self, victims: Victims, state: Rows) -> Spoofed:
        """Return the fixes that the victims receive instead of the honest ones."""
        raise NotImplementedError


class DirectedAttack(Attack):
    """An attack that pushes the fix along one direction.

    Attributes:
        frame: frame in which the direction is given: the lane's (it turns with the road) or the world's.
        direction_deg: counter-clockwise from the lane's direction, or from east; 90 in the lane's frame is left.
        side: `as_given` keeps the direction; `random` mirrors it for half of the vehicles.
    """

    frame: Literal["lane", "world"] = "lane"
    direction_deg: float = Field(90.0, ge=-360.0, le=360.0)
    side: Literal["as_given", "random"] = "random"

    def direction(self, victims: Victims) -> Floats:
        """Return (m, 2) unit vectors in the net's frame."""
        angle = np.full(len(victims.rows), np.radians(self.direction_deg))
        if self.frame == "lane":
            angle = angle + victims.lane_yaw_rad
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if self.side == "random":
            mirrored = noise.uniforms(victims.key, noise.PLAN_SIDE, 0) < 0.5
            unit[mirrored] *= -1.0
        return unit
