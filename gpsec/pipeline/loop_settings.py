"""What the loop is told before its first step: roads, sensors, and how bodies move."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gpsec.core.arrays import Ints
from gpsec.hdmap.map import HDMap
from gpsec.sensors.sense import Sensors
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.sensors.visibility import Visibility
from gpsec.traffic.body import advance
from gpsec.traffic.source import Departure, Frame
from gpsec.types.camera import NO_MISTAKES, LaneMistakes
from gpsec.types.vehicles import Vehicles

if TYPE_CHECKING:
    from gpsec.pipeline.pixels import PixelCameras

# Moves the bodies of a frame over a step of that length.
Move = Callable[[Frame, float, Vehicles], None]

# Changes what the cameras of vehicle rows see.
LookChange = Callable[[Ints, Vehicles], None]


def follow_fronts(frame: Frame, step_s: float, vehicles: Vehicles) -> None:
    """Let the bodies follow the front points of a frame."""
    advance(frame.rows, frame.front_m, step_s, vehicles)


@dataclass(frozen=True)
class LoopSettings:
    """What vehicles drive on, what they carry, and since when.

    Attributes:
        seed: of all noise.
        step_s: length of a step; step k ends at origin_s + k·step_s of simulated time.
        origin_s: see there.
        settle_s: time from departure until a vehicle is scored and may be attacked.
        hd_map: the roads, with a layer for the map spacing of each profile.
        sensors: of the profiles of the run.
        profile_of: gives the index of the sensor profile of a vehicle that departs.
        shared: what is added to all fixes, None for nothing.
        mistakes: how cameras err about the lane that they show.
        visibility: what cameras see by place, None where they lose markings by the clock.
        pixels: whose lanes come from pictures, None for nobody's.
        move: how bodies move.
        look: changes what cameras see, once the bodies are placed.
        forks: a plan's track is forked from the benign one; otherwise it takes its place, since there is only one plan
            and the attack changes where the vehicle drives.
        targets: by the name of a plan, the columns of the operating points that its attacker looks at.

    """

    seed: int
    step_s: float
    origin_s: float
    settle_s: float
    hd_map: HDMap
    sensors: Sensors
    profile_of: Callable[[Departure], int]
    shared: SharedErrors | None = None
    mistakes: LaneMistakes = NO_MISTAKES
    visibility: Visibility | None = None
    pixels: "PixelCameras | None" = None
    move: Move = follow_fronts
    look: LookChange | None = None
    forks: bool = True
    targets: Mapping[str, Ints] = field(default_factory=dict)
