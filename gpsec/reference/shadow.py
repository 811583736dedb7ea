"""The shadow of one steered vehicle, by hand: the twin of `gpsec.traffic.shadows`."""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np
import shapely


@dataclass(frozen=True)
class PlainLane:
    """A lane as SUMO has it, beside others of its edge.

    Attributes:
        edge: what it is part of.
        internal: it is within a junction.
        middle_m: from SUMO's right side of the edge to its middle.
        width_m, length_m: of it.
        has_left, has_right: there is a lane beside it; to_right: how many there are to its right.
        points_m: its shape.
    """

    edge: int
    internal: bool
    middle_m: float
    width_m: float
    length_m: float
    has_left: bool
    has_right: bool
    to_right: int
    points_m: tuple[tuple[float, float], ...]


@dataclass
class PlainShadow:
    """A steered vehicle; lengths across the road as SUMO has them.

    Attributes:
        path, lane: its path, and the lane on which SUMO has it.
        shift_m: of the path from the middle of that lane; wish_m: what is commanded; shadow_m: where SUMO has it.
        half_width_m: of its body.
        position_m, speed_mps: along the lane.
    """

    path: PlainLane
    lane: PlainLane
    shift_m: float
    wish_m: float
    shadow_m: float
    half_width_m: float
    position_m: float
    speed_mps: float

    def place(self, at: PlainLane, step_s: float) -> tuple[float, float]:
        """Move on to the next step, on lane `at`; return the lateral position on it and the nudge from there."""
        if at.edge != self.path.edge:
            kept_m = self.path.middle_m - self.lane.middle_m
            self.shift_m, self.shadow_m, self.path = self.shift_m + kept_m, self.shadow_m + kept_m, at
        self.lane = at
        self.shift_m = _towards(0.0, self.shift_m, min(0.9, sin(radians(15.0)) * max(self.speed_mps, 0.0)) * step_s)
        left_m = at.length_m - self.position_m
        wanted_m = self.shift_m + self.wish_m
        across = -(wanted_m + 0.5 * self.path.width_m) / self.path.width_m  # lanes to the right, from the path's edge
        beyond = across > (0.0 if self.path.has_left else 1.0)
        more_m = 40.0 if beyond and self.path.to_right >= (1 if self.path.has_left else 2) else 0.0
        near = at.internal or left_m < 30.0 + more_m or left_m < 3.0 * self.speed_mps + more_m
        most_m = max(0.5 * self.path.width_m - self.half_width_m, 0.0) if near else 8.0
        self.shadow_m = _towards(float(np.clip(wanted_m, -most_m, most_m)), self.shadow_m, 2.0 * step_s)
        put_m = self.shadow_m + self.path.middle_m - at.middle_m
        outwards = not (at.has_left if put_m > 0.0 else at.has_right)
        nudge_m = -0.004 if (put_m > 0.0) is outwards else 0.004
        return put_m - nudge_m, nudge_m

    def settle(self, at: PlainLane, position_m: float, step_s: float, left_sign: float) -> tuple[float, float, float]:
        """Take in where SUMO has it after the step; return the surplus to the left, and its vector."""
        if at is self.lane:
            self.speed_mps = (position_m - self.position_m) / step_s
        self.position_m = position_m
        surplus_m = left_sign * (self.shift_m + self.wish_m - self.shadow_m)
        yaw = _course(at, position_m)
        return surplus_m, -surplus_m * sin(yaw), surplus_m * cos(yaw)


def _towards(goal: float, value: float, most: float) -> float:
    return goal if abs(goal - value) <= most else value + most * float(np.sign(goal - value))


def _course(lane: PlainLane, position_m: float) -> float:
    """Return the direction of a lane, even between its points, at each of which it is the mean of both sides."""
    line = shapely.LineString(lane.points_m)
    way = np.diff(np.array(lane.points_m), axis=0)
    course = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
    at_points = np.concatenate([course[:1], 0.5 * (course[1:] + course[:-1]), course[-1:]])
    along_m = np.concatenate([[0.0], np.cumsum(np.hypot(way[:, 0], way[:, 1]))])
    return float(np.interp(position_m * line.length / lane.length_m, along_m, at_points))
