"""The sensor data of one vehicle in one step, under one attack plan."""

from dataclasses import dataclass
from typing import NamedTuple

from gpsec.core.arrays import Floats


class Whitened(NamedTuple):
    """What the monitor of a track says; the fields are those of `gpsec.detection.channels.Channels`."""

    tested: bool = False
    along: float = 0.0
    across: float = 0.0
    camera: float = 0.0
    blind: bool = False
    fix_age_s: float = 0.0
    joint: float = 0.0
    innovation: float = 0.0
    separation: float = 0.0


NOTHING_WHITENED = Whitened()


@dataclass(frozen=True)
class Sight:
    """Sensor data as plain numbers, None for what is missing.

    Attributes:
        fix_m: (2,) GNSS position after the attack.
        lane: index of the lane that the vehicle believes to be on, -1 for none.
        heading_rad: yaw as the vehicle knows it.
        speed_mps, yaw_rate_rps: odometer and gyro over the step.
        lane_offset_m: from the lane's centre as the camera sees it (-C0), left positive; None, too, where it is not
            known which lane that is.
        lane_slope: of the lane in the vehicle's frame, as the camera sees it (C1).
        curvature_per_m: of the lane, as the camera sees it (2·C2).
        camera_sigma_m: standard deviation that the camera states.
        unmatched: no lane of the map matches the fix that is compared with what the camera sees.
        told: what the monitor says, if there is one.

    """

    fix_m: Floats | None
    lane: int
    heading_rad: float
    speed_mps: float
    yaw_rate_rps: float
    lane_offset_m: float | None
    lane_slope: float
    curvature_per_m: float
    camera_sigma_m: float
    unmatched: bool = False
    told: Whitened = NOTHING_WHITENED
