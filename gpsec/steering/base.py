"""What all lateral dynamics and all reactions share: frozen parameters, a state of rows, formulas on arrays."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict

from gpsec.core.arrays import Flags, Floats, Ints, Keys
from gpsec.core.tables import Table


class Nothing(NamedTuple):
    """What a part remembers that needs no memory."""


class SteeringPart(BaseModel):
    """Base of the open parts of steering. The fields of a subclass are its parameters, with units and bounds.

    What it remembers of each vehicle is a structure of arrays, its `state` (see `gpsec.core.tables`), whose rows are
    fresh when gpsec takes control. A row's result must not depend on the other rows, to the last bit: numpy's
    arithmetic and comparisons are safe, its sines and powers are not.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    name: ClassVar[str]
    state: ClassVar[type[Any]] = Nothing

    def new_state(self, capacity: int) -> Table[Any]:
        """Return the table of the part's own `state`, with `capacity` vehicle rows."""
        return Table(self.state, capacity)

    def _require(self, label: str, array: np.ndarray, count: int, dtype: type[np.generic]) -> None:
        if array.shape != (count,) or array.dtype != np.dtype(dtype):
            found = f"{array.shape} of {array.dtype}"
            raise TypeError(f"'{self.name}': {label} must be ({count},) of {np.dtype(dtype)}, found {found}")


@dataclass(frozen=True)
class LateralMotion:
    """Vehicles that gpsec steers in this step; m of them.

    Attributes:
        rows: (m,) vehicle rows, for the part's own state.
        step_s: length of the step.
        offset_m: (m,) true displacement from the middle of the path, left positive.
        rate_mps: (m,) its rate.
        wanted_m: (m,) displacement that the vehicle steers to: what it takes for the middle of its path.
        speed_mps: (m,) of the vehicle.
    """

    rows: Ints
    step_s: float
    offset_m: Floats
    rate_mps: Floats
    wanted_m: Floats
    speed_mps: Floats


@dataclass(frozen=True)
class Moved:
    """Where the vehicles are a step later: offset_m (m,) and its rate, rate_mps (m,)."""

    offset_m: Floats
    rate_mps: Floats


class LateralDynamics(SteeringPart):
    """How a vehicle moves across the road to where it wants to be; a subclass writes `move`."""

    def move(self, motion: LateralMotion, state: Any) -> Moved:
        """Return offset and rate after the step; `state` is read and written at `motion.rows`."""
        raise NotImplementedError

    def apply(self, motion: LateralMotion, state: Any) -> Moved:
        """Return what `move` gives, after a look at its shapes.

        Raises:
            TypeError: `move` gave arrays of another shape or type, a mistake in the part.
        """
        moved = self.move(motion, state)
        for label in ("offset_m", "rate_mps"):
            self._require(label, getattr(moved, label), len(motion.rows), np.float64)
        return moved


class Follow(IntEnum):
    """What a vehicle steers by."""

    ESTIMATE = 0
    LANE = 1
    EDGE = 2


@dataclass(frozen=True)
class Situation:
    """Vehicles that may react in this step; m of them.

    Attributes:
        rows: (m,) vehicle rows, for the reaction's own state.
        key: (m,) the vehicle's key for counter-based noise.
        step: step of the loop; step_s: its length.
        alarm: (m,) the detector of the defence that steers is in alarm.
        speed_mps: (m,) of the vehicle.
    """

    rows: Ints
    key: Keys
    step: int
    step_s: float
    alarm: Flags
    speed_mps: Floats


@dataclass(frozen=True)
class Conduct:
    """What the vehicles do: follow (m,), a `Follow`, and brake_mps2 (m,), 0 where they drive on."""

    follow: Ints
    brake_mps2: Floats


class Reaction(SteeringPart):
    """What a vehicle does on an alarm; a subclass writes `react`."""

    def react(self, situation: Situation, state: Any) -> Conduct:
        """Return what the vehicles do; `state` is read and written at `situation.rows`."""
        raise NotImplementedError

    def apply(self, situation: Situation, state: Any) -> Conduct:
        """Return what `react` gives, after a look at its shapes.

        Raises:
            TypeError: `react` gave arrays of another shape or type, a mistake in the part.
        """
        conduct = self.react(situation, state)
        self._require("follow", conduct.follow, len(situation.rows), np.int32)
        self._require("brake_mps2", conduct.brake_mps2, len(situation.rows), np.float64)
        return conduct
