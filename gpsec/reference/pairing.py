"""Pairs camera samples with fixes for one track, by the vehicle's own odometry."""

from dataclasses import dataclass
from math import inf

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.detection.pairing import DetectionClock
from gpsec.reference.filters import arc
from gpsec.reference.sight import Sight


@dataclass(frozen=True)
class Pair:
    """A camera sample and a fix that are compared.

    Attributes:
        sight: what was seen in the step of the camera sample.
        offset_m: from the lane's centre as the camera saw it, left positive.
        fix_m: (2,) the fix, moved to that time.
        now_m: (2,) the fix, moved to now.

    """

    sight: Sight
    offset_m: float
    fix_m: Floats
    now_m: Floats


@dataclass(frozen=True)
class Residual:
    """The residual of a pair.

    Attributes:
        z_m: d_camera - d_map(fix).
        fix_m: (2,) the fix, moved to now.

    """

    z_m: float
    fix_m: Floats


@dataclass(frozen=True)
class _Fix:
    """A fix, when it came, and where the vehicle was by its own odometry."""

    step: int
    place_m: Floats
    fix_m: Floats


@dataclass(frozen=True)
class _Lane:
    """A camera sample, likewise."""

    step: int
    place_m: Floats
    offset_m: float
    sight: Sight


class Pairing:
    """The newest camera sample and the newest fix of one track."""

    def __init__(self, step_s: float, fix_steps: int, camera_steps: int) -> None:
        self._step_s = step_s
        self._clock = DetectionClock(step_s)
        self._fix_steps = fix_steps
        self._camera_steps = camera_steps
        self._place_m = np.zeros(2)
        self._lane: _Lane | None = None
        self._fix: _Fix | None = None
        self._last_tick = -inf
        self._last_pair = -inf

    def step(self, number: int, sight: Sight) -> Pair | None:
        """Take step `number`; return the pair to compare in it, if there is one."""
        turn = sight.yaw_rate_rps * self._step_s
        self._place_m = self._place_m + arc(sight.heading_rad - turn, sight.speed_mps * self._step_s, turn)
        if self._clock.ticks(number):
            self._last_tick = number
        if sight.fix_m is not None:
            self._fix = _Fix(number, self._place_m, sight.fix_m)
        if sight.lane_offset_m is not None:
            self._lane = _Lane(number, self._place_m, sight.lane_offset_m, sight)
        fix, lane = self._fix, self._lane
        if self._last_tick <= self._last_pair or fix is None or lane is None:
            return None
        if number - fix.step > self._fix_steps or number - lane.step > self._camera_steps:
            return None
        self._last_pair, self._fix, self._lane = number, None, None
        moved_m = fix.fix_m - fix.place_m
        return Pair(lane.sight, lane.offset_m, moved_m + lane.place_m, moved_m + self._place_m)
