"""What every attack shares: its parameters are a frozen model, its formula works on arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from gpsec.attacks.probing import Knowledge, Probe, asks_nobody
from gpsec.core import noise
from gpsec.core.arrays import Flags, Floats, Ints, Keys
from gpsec.core.kernels import allocating_kernel
from gpsec.core.tables import Table


@dataclass(frozen=True)
class Victims:
    """The tracks of one plan whose attack is active in this step; m of them.

    The attacker is taken to know where the road lies (its map), where that has no markings for a camera, and what an
    undefended victim believes; it knows nothing of detectors, unless the attack states a `Knowledge`.

    Attributes:
        rows: (m,) track rows, for the attack's own state.
        key: (m,) the vehicle's key for counter-based noise.
        step: step of the loop; step_s: its length.
        elapsed_s: (m,) since the attack on this vehicle began, 0 in its first step.
        fix_m: (m, 2) honest GNSS fix in the net's frame; fix_valid: (m,) there is one in this step.
        lane_yaw_rad: (m,) direction of the lane at the vehicle.
        lane_width_m: (m,) of that lane.
        left_lane, right_lane: (m,) there is a lane of either direction beside it on that side.
        blind: (m,) no lane is marked where the vehicle is, so that its camera sees none.
        deviation_m: (m,) cross-track error of the undefended estimate after the last step, left positive.
        past_fix: past_fix(delay_s) gives the latest honest fixes (m, 2) that are at least that old, and (m,) whether
            the vehicle has had one so early.
        probe: probe(moved_m) says what detectors would find in this step, were the honest fixes moved by (m, C, 2)
            metres; for attacks that state a `Knowledge`.
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
    blind: Flags
    deviation_m: Floats
    past_fix: Callable[[float], tuple[Floats, Flags]]
    probe: Probe = asks_nobody


@dataclass(frozen=True)
class Spoofed:
    """Fixes after an attack: fix_m (m, 2) and whether there is one, valid (m,)."""

    fix_m: Floats
    valid: Flags


class NoState(NamedTuple):
    """What an attack remembers that needs no memory."""


class Attack(BaseModel):
    """A way to falsify GNSS fixes. The fields of a subclass are its parameters, with units and bounds.

    A subclass states its `name` and writes `spoof`, the formula. What it remembers of each track is a structure of
    arrays, its `state` (see `gpsec.core.tables`), whose rows are fresh when an attack begins. A row's result must not
    depend on the other rows, to the last bit: numpy's arithmetic and comparisons are safe; sines and powers come from
    `unit_vectors` and `powers`, because numpy computes them differently in different places of an array.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    name: ClassVar[str]
    state: ClassVar[type[Any]] = NoState

    def needed_memory_s(self) -> float:
        """Return how far back `Victims.past_fix` must reach."""
        return 0.0

    def known(self) -> Knowledge | None:
        """Return what the attacker knows of detectors, None for nothing."""
        return None

    def new_state(self, capacity: int) -> Table[Any]:
        """Return the table of the attack's own `state`, with `capacity` track rows."""
        return Table(self.state, capacity)

    def spoof(self, victims: Victims, state: Any) -> Spoofed:
        """Return the fixes that the victims receive instead of the honest ones; `state` is read and written."""
        raise NotImplementedError

    def apply(self, victims: Victims, state: Any) -> Spoofed:
        """Return what `spoof` gives, after a look at its shapes.

        Raises:
            TypeError: `spoof` gave arrays of another shape or type, a mistake in the attack.
        """
        spoofed = self.spoof(victims, state)
        m = len(victims.rows)
        for label, array, shape, dtype in (
            ("fix_m", spoofed.fix_m, (m, 2), np.dtype(np.float64)),
            ("valid", spoofed.valid, (m,), np.dtype(np.bool_)),
        ):
            if array.shape != shape or array.dtype != dtype:
                found = f"{array.shape} of {array.dtype}"
                raise TypeError(f"attack '{self.name}': {label} must be {shape} of {dtype}, found {found}")
        return spoofed


@allocating_kernel
def unit_vectors(angle_rad: Floats) -> Floats:
    """Return (m, 2) unit vectors in the directions (m,), counter-clockwise from east."""
    unit = np.empty((len(angle_rad), 2))
    for i in range(len(angle_rad)):
        unit[i, 0] = cos(angle_rad[i])
        unit[i, 1] = sin(angle_rad[i])
    return unit


@allocating_kernel
def powers(base: float, exponent: Floats) -> Floats:
    """Return base ** exponent for each of (m,) exponents."""
    result = np.empty(len(exponent))
    for i in range(len(exponent)):
        result[i] = base ** exponent[i]
    return result


def random_signs(victims: Victims) -> Floats:
    """Return (m,) +1 or -1, each for half of the vehicles; a vehicle has the same sign under every plan."""
    return np.where(noise.uniforms(victims.key, noise.PLAN_SIDE, 0) < 0.5, -1.0, 1.0)


def displace_left(victims: Victims, offset_m: Floats) -> Spoofed:
    """Return the honest fixes moved by (m,) metres to the left of the lane's direction (negative: right)."""
    left = unit_vectors(victims.lane_yaw_rad + 0.5 * np.pi)
    return Spoofed(victims.fix_m + offset_m[:, np.newaxis] * left, victims.fix_valid.copy())


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
        unit = unit_vectors(angle)
        return unit * random_signs(victims)[:, np.newaxis] if self.side == "random" else unit

    def displace(self, victims: Victims, offset_m: Floats) -> Spoofed:
        """Return the honest fixes moved by (m,) metres along the direction."""
        moved = victims.fix_m + offset_m[:, np.newaxis] * self.direction(victims)
        return Spoofed(moved, victims.fix_valid.copy())
