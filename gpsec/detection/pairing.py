"""Which camera sample is compared with which fix, and when: the same for every step length.

Camera and receiver have clocks of their own, and at a short step hardly ever a sample in the same one. So the newest
sample of each is kept until it is compared, and the fix is moved to the camera's time by what the vehicle itself
measures of its seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.geo import dead_reckon
from gpsec.core.kernels import inline
from gpsec.core.tables import blank
from gpsec.types.tracks import SAMPLE_S
from gpsec.types.vehicles import Measurements


@dataclass(frozen=True)
class DetectionClock:
    """Ticks every `SAMPLE_S`, or in every step where steps are longer.

    Attributes:
        step_s: length of a step.
    """

    step_s: float

    def ticks(self, step: int) -> bool:
        """Return whether a tick falls into step `step` (from 0), which ends `step` + 1 steps after the begin."""
        per_step = self.step_s / SAMPLE_S
        return per_step > 1.0 - 1e-9 or floor((step + 1) * per_step + 1e-6) > floor(step * per_step + 1e-6)


class Sampling(NamedTuple):
    """How old samples may be when they are compared, in steps; P profiles.

    Attributes:
        step_s: length of a step.
        fix_steps, camera_steps: (P,) a period of the sensor, rounded up.
    """

    step_s: float
    fix_steps: Ints
    camera_steps: Ints

    @classmethod
    def of(cls, step_s: float, fix_hz: Sequence[float], camera_hz: Sequence[float]) -> "Sampling":
        """Return that of profiles with (P,) rates."""
        steps = [[ceil(1.0 / rate / step_s - 1e-6) for rate in rates] for rates in (fix_hz, camera_hz)]
        return cls(step_s, *(np.array(one, np.int32) for one in steps))


class Pending(NamedTuple):
    """The newest camera sample and the newest fix of M tracks, each compared once.

    Attributes:
        due: (M,) no residual was formed since the last tick.
        formed: (M,) a valid residual was formed in this step.
        elapsed_steps: (M,) steps since the valid residual before this step, or since the row is in use.
        camera, fix: (M,) a sample waits.
        camera_age, fix_age: (M,) steps since it came.
        since_camera_m, since_fix_m: (M, 2) way since then, by odometer, gyro and heading, in the net's frame.
        lane: (M,) index of the lane that the vehicle believed to be on.
        offset_m: (M,) d_camera = -C0, left positive.
        heading_rad: (M,) at the time of the camera sample.
        curvature_per_m, sigma_m: (M,) of the lane as the camera saw it (2·C2), and the standard deviation it stated.
        fix_m: (M, 2) GNSS position after the attack.
    """

    due: Flags = blank(False)
    formed: Flags = blank(False)
    elapsed_steps: Ints = blank(0)
    camera: Flags = blank(False)
    camera_age: Ints = blank(0)
    since_camera_m: Floats = blank(0.0, 2)
    lane: Ints = blank(0)
    offset_m: Floats = blank(0.0)
    heading_rad: Floats = blank(0.0)
    curvature_per_m: Floats = blank(0.0)
    sigma_m: Floats = blank(0.0)
    fix: Flags = blank(False)
    fix_age: Ints = blank(0)
    since_fix_m: Floats = blank(0.0, 2)
    fix_m: Floats = blank(0.0, 2)


@inline
def grow_older(pending: Pending, row: int, sampling: Sampling, profile: int, seen: Measurements, vehicle: int) -> None:
    """Let what waits at `row` be a step older; what is older than a period of its sensor is given up."""
    if not (pending.camera[row] or pending.fix[row]):
        return
    turn = seen.yaw_rate_rps[vehicle] * sampling.step_s
    way = seen.speed_mps[vehicle] * sampling.step_s
    east, north = dead_reckon(0.0, 0.0, seen.heading_rad[vehicle] - turn, way, turn)
    pending.since_camera_m[row, 0] += east
    pending.since_camera_m[row, 1] += north
    pending.since_fix_m[row, 0] += east
    pending.since_fix_m[row, 1] += north
    pending.camera_age[row] += 1
    pending.fix_age[row] += 1
    pending.camera[row] = pending.camera[row] and pending.camera_age[row] <= sampling.camera_steps[profile]
    pending.fix[row] = pending.fix[row] and pending.fix_age[row] <= sampling.fix_steps[profile]


@inline
def keep_fix(pending: Pending, row: int, x_m: float, y_m: float) -> None:
    """Keep a fix of this step."""
    pending.fix[row] = True
    pending.fix_age[row] = 0
    pending.since_fix_m[row, 0], pending.since_fix_m[row, 1] = 0.0, 0.0
    pending.fix_m[row, 0], pending.fix_m[row, 1] = x_m, y_m


@inline
def keep_lane(
    pending: Pending, row: int, lane: int, heading_rad: float, offset_m: float, curvature_per_m: float, sigma_m: float
) -> None:
    """Keep a camera sample of this step."""
    pending.camera[row] = True
    pending.camera_age[row] = 0
    pending.since_camera_m[row, 0], pending.since_camera_m[row, 1] = 0.0, 0.0
    pending.lane[row] = lane
    pending.heading_rad[row] = heading_rad
    pending.offset_m[row] = offset_m
    pending.curvature_per_m[row] = curvature_per_m
    pending.sigma_m[row] = sigma_m


@inline
def take_pair(pending: Pending, row: int) -> bool:
    """Return whether a camera sample and a fix are to be compared now; then neither waits any longer."""
    ready = pending.due[row] and pending.camera[row] and pending.fix[row]
    if ready:
        pending.due[row] = False
        pending.camera[row] = False
        pending.fix[row] = False
    return bool(ready)
