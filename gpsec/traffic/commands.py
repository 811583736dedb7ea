"""What the evaluation asks of a running simulation, and what comes back with its frames: the closed loop."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints


class CommandKind(IntEnum):
    """What is to be done with a vehicle."""

    STEER = 0
    RELEASE = 1
    BRAKE = 2
    REMOVE = 3


# The same as numbers, for kernels.
STEER, RELEASE, BRAKE, REMOVE = map(int, CommandKind)


@dataclass(frozen=True)
class Commands:
    """What is to be done before the next step; n vehicles.

    Attributes:
        rows: (n,) vehicle rows, or numbers among the `Others` of a frame.
        others: (n,) the row is such a number; for these there are BRAKE and REMOVE alone.
        order: (n,) a `CommandKind`. STEER holds until RELEASE; BRAKE and the braking of STEER are for one step.
        lateral_m: (n,) of STEER: displacement from the middle of the vehicle's path, left positive.
        brake_mps2: (n,) of STEER and BRAKE: the deceleration; 0 leaves the speed to SUMO.
    """

    rows: Ints
    others: Flags
    order: Ints
    lateral_m: Floats
    brake_mps2: Floats

    @staticmethod
    def none() -> "Commands":
        """Return no command at all."""
        whole, real = np.zeros(0, np.int32), np.zeros(0)
        return Commands(whole, np.zeros(0, np.bool_), whole, real, real)


@dataclass(frozen=True)
class Others:
    """Vehicles on the road that are not part of the fleet; n of them.

    Attributes:
        number: (n,) of each, kept for as long as it is in the simulation; entered: those that are new.
        front_m: (n, 2) centre of the front bumper.
        yaw_rad, speed_mps: (n,) as SUMO says.
        length_m, width_m: (n,) of the bodies.
        sumo_id: of each.
    """

    number: Ints
    entered: Ints
    front_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    length_m: Floats
    width_m: Floats
    sumo_id: tuple[str, ...] = ()

    @staticmethod
    def nobody() -> "Others":
        """Return nobody at all."""
        whole, real = np.zeros(0, np.int32), np.zeros(0)
        return Others(whole, whole, np.zeros((0, 2)), real, real, real, real)


@dataclass(frozen=True)
class Carried:
    """How the commands before a step were carried out.

    Attributes:
        rows: (n,) vehicle rows that are steered, ascending.
        path: (n,) index in the HD map of the lane that is the vehicle's path.
        surplus_m: (n,) how far to the left of where SUMO has it a vehicle truly is.
        others: who else is on the road.
        removed: vehicles that have been taken out by command so far.
        teleports: teleports that have begun so far.
        lost_s: seconds that the vehicles of the fleet have lost so far against free driving, as SUMO counts them.
        spent_s: wall-clock seconds spent in carrying out commands so far.
        stuck: vehicles so far that stood for no reason, see `gpsec.traffic.delays`.
    """

    rows: Ints
    path: Ints
    surplus_m: Floats
    others: Others
    removed: int
    teleports: int
    lost_s: float
    spent_s: float
    stuck: int
