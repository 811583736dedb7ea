"""Which camera sample is compared with which fix, and when: the same for every step length.

Camera and receiver have clocks of their own, and at a short step hardly ever a sample in the same one. So the newest
sample of each is kept until it is compared, and the fix is moved to the camera's time by what the vehicle itself
measures of its motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.geo import dead_reckon
from gpsec.core.kernels import inline
from gpsec.core.tables import Rows
from gpsec.types.tracks import SAMPLE_S


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


class Motion(NamedTuple):
    """What N vehicles measure of their motion in a step: fields of `Measurements`."""

    speed_mps: Floats
    yaw_rate_rps: Floats
    heading_rad: Floats


class Waiting(NamedTuple):
    """The fields of `Samples`, as kernels take them."""

    due: Flags
    camera: Flags
    camera_age: Ints
    since_camera_m: Floats
    lane: Ints
    offset_m: Floats
    heading_rad: Floats
    curvature_per_m: Floats
    sigma_m: Floats
    fix: Flags
    fix_age: Ints
    since_fix_m: Floats
    fix_m: Floats


@dataclass
class Samples(Rows):
    """The newest camera sample and the newest fix of M tracks, each compared once.

    Attributes:
        due: (M,) no residual was formed since the last tick.
        camera, fix: (M,) a sample waits.
        camera_age, fix_age: (M,) steps since it came.
        since_camera_m, since_fix_m: (M, 2) way since then, by odometer, gyro and heading, in the net's frame.
        lane: (M,) index of the lane that the camera followed.
        offset_m: (M,) d_camera = -C0, left positive.
        heading_rad: (M,) at the time of the camera sample.
        curvature_per_m, sigma_m: (M,) of the lane as the camera saw it (2·C2), and the standard deviation it stated.
        fix_m: (M, 2) GNSS position after the attack.
    """

    due: Flags
    camera: Flags
    camera_age: Ints
    since_camera_m: Floats
    lane: Ints
    offset_m: Floats
    heading_rad: Floats
    curvature_per_m: Floats
    sigma_m: Floats
    fix: Flags
    fix_age: Ints
    since_fix_m: Floats
    fix_m: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows without a sample."""
        n = capacity
        return cls(
            due=np.zeros(n, np.bool_),
            camera=np.zeros(n, np.bool_),
            camera_age=np.zeros(n, np.int32),
            since_camera_m=np.zeros((n, 2)),
            lane=np.zeros(n, np.int32),
            offset_m=np.zeros(n),
            heading_rad=np.zeros(n),
            curvature_per_m=np.zeros(n),
            sigma_m=np.zeros(n),
            fix=np.zeros(n, np.bool_),
            fix_age=np.zeros(n, np.int32),
            since_fix_m=np.zeros((n, 2)),
            fix_m=np.zeros((n, 2)),
        )

    def arrays(self) -> Waiting:
        """Return the arrays themselves."""
        return Waiting(*(getattr(self, name) for name in Waiting._fields))


@inline
def grow_older(waiting: Waiting, row: int, sampling: Sampling, profile: int, motion: Motion, vehicle: int) -> None:
    """Let what waits at `row` be a step older; what is older than a period of its sensor is given up."""
    if not (waiting.camera[row] or waiting.fix[row]):
        return
    turn = motion.yaw_rate_rps[vehicle] * sampling.step_s
    way = motion.speed_mps[vehicle] * sampling.step_s
    east, north = dead_reckon(0.0, 0.0, motion.heading_rad[vehicle] - turn, way, turn)
    waiting.since_camera_m[row, 0] += east
    waiting.since_camera_m[row, 1] += north
    waiting.since_fix_m[row, 0] += east
    waiting.since_fix_m[row, 1] += north
    waiting.camera_age[row] += 1
    waiting.fix_age[row] += 1
    waiting.camera[row] = waiting.camera[row] and waiting.camera_age[row] <= sampling.camera_steps[profile]
    waiting.fix[row] = waiting.fix[row] and waiting.fix_age[row] <= sampling.fix_steps[profile]


@inline
def keep_fix(waiting: Waiting, row: int, x_m: float, y_m: float) -> None:
    """Keep a fix of this step."""
    waiting.fix[row] = True
    waiting.fix_age[row] = 0
    waiting.since_fix_m[row, 0], waiting.since_fix_m[row, 1] = 0.0, 0.0
    waiting.fix_m[row, 0], waiting.fix_m[row, 1] = x_m, y_m


@inline
def keep_lane(
    waiting: Waiting, row: int, lane: int, heading_rad: float, offset_m: float, curvature_per_m: float, sigma_m: float
) -> None:
    """Keep a camera sample of this step."""
    waiting.camera[row] = True
    waiting.camera_age[row] = 0
    waiting.since_camera_m[row, 0], waiting.since_camera_m[row, 1] = 0.0, 0.0
    waiting.lane[row] = lane
    waiting.heading_rad[row] = heading_rad
    waiting.offset_m[row] = offset_m
    waiting.curvature_per_m[row] = curvature_per_m
    waiting.sigma_m[row] = sigma_m


@inline
def take_pair(waiting: Waiting, row: int) -> bool:
    """Return whether a camera sample and a fix are to be compared now; then neither waits any longer."""
    ready = waiting.due[row] and waiting.camera[row] and waiting.fix[row]
    if ready:
        waiting.due[row] = False
        waiting.camera[row] = False
        waiting.fix[row] = False
    return bool(ready)
