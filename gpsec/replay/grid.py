"""Puts a log on the steps of a run: the truth at each of them, and what each sensor had given by then."""

from dataclasses import dataclass
from math import pi

import numpy as np

from gpsec.core.arrays import Flags, Floats, Longs
from gpsec.replay.log import DriveLog, Samples

LOG_STEP_S = 0.1


@dataclass(frozen=True)
class SteppedDrive:
    """A drive in S steps of `LOG_STEP_S`; what the log has not is empty, (0, …).

    Attributes:
        begin_s: (1,) of the log's clock, at which step 0 begins.
        rear_m: (S, 2) the reference at the end of each step.
        yaw_rad: (S,) of it.
        speed_mps, yaw_rate_rps: (S,) its means over the step.
        odometer_mps, gyro_rps: (S,) means of the samples in the step, held where there are none.
        heading_rad: (S,).
        fix_m, fix_there: (S, 2), (S,) newest fix that arrived in the step, carried on to its end by odometer and yaw.
        lane: (S, 5) C0 … C3 and the stated σ; lane_there: (S,).
    """

    begin_s: Floats
    rear_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    yaw_rate_rps: Floats
    odometer_mps: Floats
    gyro_rps: Floats
    heading_rad: Floats
    fix_m: Floats
    fix_there: Flags
    lane: Floats
    lane_there: Flags

    def __len__(self) -> int:
        return len(self.yaw_rad)


def on_steps(log: DriveLog) -> SteppedDrive:
    """Return a log on steps: from when every sensor has given something, to the end of the pose."""
    begin_s = max([float(log.pose.time_s[0]), *(float(one.time_s[0]) for one in log.sensors().values())])
    count = int((log.pose.time_s[-1] - begin_s) / LOG_STEP_S + 1e-9)
    edge_s: Floats = begin_s + LOG_STEP_S * np.arange(count + 1, dtype=np.float64)
    east, north, yaw = _pose_at(log.pose, edge_s)
    way_m = np.hypot(np.diff(east), np.diff(north))
    ahead = np.cos(np.arctan2(np.diff(north), np.diff(east)) - yaw[1:]) >= 0.0
    true_mps = np.where(ahead, way_m, -way_m) / LOG_STEP_S
    odometer = _mean_in_steps(log.speed, edge_s)
    moved_mps = odometer if len(odometer) else true_mps
    fix_m, fix_there = _fixes_in_steps(log, edge_s, moved_mps, yaw)
    lane, lane_there = _newest_in_steps(log.lane, edge_s)
    return SteppedDrive(
        begin_s=np.array([begin_s]),
        rear_m=np.column_stack([east, north])[1:],
        yaw_rad=_wrapped(yaw[1:]),
        speed_mps=true_mps,
        yaw_rate_rps=np.diff(yaw) / LOG_STEP_S,
        odometer_mps=odometer,
        gyro_rps=_mean_in_steps(log.yaw_rate, edge_s),
        heading_rad=_heading_at(log.heading, edge_s[1:]),
        fix_m=fix_m,
        fix_there=fix_there,
        lane=lane,
        lane_there=lane_there,
    )


def _pose_at(pose: Samples, time_s: Floats) -> tuple[Floats, Floats, Floats]:
    east, north, yaw = pose.numbers.T
    at = [np.interp(time_s, pose.time_s, axis) for axis in (east, north, np.unwrap(yaw))]
    return at[0], at[1], at[2]


def _in_step(time_s: Floats, edge_s: Floats) -> Longs:
    """Return the step that each time lies in, up to its end; -1 before the first, S behind the last."""
    return np.asarray(np.searchsorted(edge_s, time_s, side="left") - 1, np.int64)


def _mean_in_steps(samples: Samples | None, edge_s: Floats) -> Floats:
    if samples is None:
        return np.zeros(0)
    steps = len(edge_s) - 1
    step = _in_step(samples.time_s, edge_s)
    inside = (step >= 0) & (step < steps)
    number = np.bincount(step[inside], minlength=steps)
    total = np.bincount(step[inside], samples.numbers[inside, 0], minlength=steps)
    # Held: the newest sample before a step without one.
    last = np.maximum(np.searchsorted(samples.time_s, edge_s[1:], side="right") - 1, 0)
    return np.where(number > 0, total / np.maximum(number, 1), samples.numbers[last, 0])


def _newest_in_steps(samples: Samples | None, edge_s: Floats) -> tuple[Floats, Flags]:
    if samples is None:
        return np.zeros((0, 5)), np.zeros(0, np.bool_)
    last = np.searchsorted(samples.time_s, edge_s[1:], side="right") - 1
    there = (last >= 0) & (samples.time_s[np.maximum(last, 0)] > edge_s[:-1])
    return np.where(there[:, None], samples.numbers[np.maximum(last, 0)], 0.0), there


def _heading_at(samples: Samples | None, time_s: Floats) -> Floats:
    if samples is None:
        return np.zeros(0)
    return _wrapped(np.interp(time_s, samples.time_s, np.unwrap(samples.numbers[:, 0])))


def _fixes_in_steps(log: DriveLog, edge_s: Floats, moved_mps: Floats, yaw: Floats) -> tuple[Floats, Flags]:
    """Return the newest fix of each step, carried on from when it was true by speed and yaw."""
    if log.fixes is None:
        return np.zeros((0, 2)), np.zeros(0, np.bool_)
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    moved_m = LOG_STEP_S * moved_mps[:, None] * np.column_stack([np.cos(middle), np.sin(middle)])
    way_m = np.concatenate([np.zeros((1, 2)), np.cumsum(moved_m, axis=0)])
    last = np.searchsorted(log.fixes.time_s, edge_s[1:], side="right") - 1
    at = np.maximum(last, 0)
    there = (last >= 0) & (log.fixes.time_s[at] > edge_s[:-1])
    since_m = way_m[1:] - np.column_stack([np.interp(log.fixes.valid_s[at], edge_s, axis) for axis in way_m.T])
    # A fix of before the first step has not been carried on as far as it should be.
    there &= log.fixes.valid_s[at] >= edge_s[0]
    return np.where(there[:, None], log.fixes.position_m[at] + since_m, 0.0), there


def _wrapped(angle_rad: Floats) -> Floats:
    wrapped: Floats = (angle_rad + pi) % (2.0 * pi) - pi
    return wrapped
