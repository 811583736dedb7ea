"""What may be wrong with a log: each is one sentence that names the file, the column and the row."""

from math import degrees, pi

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import GpsecError
from gpsec.replay.log import DriveLog, Samples

MIN_DRIVE_S, MIN_WAY_M, MAX_POSE_GAP_S = 20.0, 50.0, 1.0
MAX_DRIVE_S = 86_400.0
_FASTEST_MPS = 150.0
# A heading this far from the course of the wheels, and a length this far from another one, is of another unit.
_COURSE_RAD, _FACTOR = 0.5, 1.5
# Slower than this, neither has a meaning.
_MOVING_MPS, _TURNING_RPS = 2.0, 0.02
# No gyro of a vehicle has such a bias (3°/s).
_MOST_BIAS_RPS = 0.05


def check_log(log: DriveLog) -> None:
    """Refuse a log that no run can be made of.

    Raises:
        GpsecError: a time runs backwards, a value is no number or of another unit, the pose has a gap, or the drive is
            too short.
    """
    every = {"pose": log.pose, **log.sensors()}
    if log.fixes is not None:
        every["fix"] = Samples(log.fixes.time_s, np.column_stack([log.fixes.valid_s, log.fixes.position_m]))
    for name, samples in every.items():
        _check_samples(f"{log.source}: {name}", samples)
    _check_pose(log)
    _check_fixes(log)
    for name, samples in log.sensors().items():
        if samples.time_s[-1] < log.pose.time_s[0] or samples.time_s[0] > log.pose.time_s[-1]:
            raise GpsecError(
                f"{log.source}: {name}: expected times between those of the pose, {log.pose.time_s[0]:g} to"
                f" {log.pose.time_s[-1]:g} s, found {samples.time_s[0]:g} to {samples.time_s[-1]:g}"
            )
    _check_units(log)


def _check_samples(where: str, samples: Samples) -> None:
    time_s, values = samples.time_s, samples.numbers
    if len(time_s) < 2:
        raise GpsecError(f"{where}: expected two samples or more, found {len(time_s)}")
    for name, numbers in (("time", time_s[:, None]), ("value", values)):
        if len(wrong := np.flatnonzero(~np.isfinite(numbers).all(axis=1))):
            raise GpsecError(f"{where}: sample {wrong[0] + 1}: expected a number as its {name}, found NaN or infinite")
    if len(back := np.flatnonzero(np.diff(time_s) < 0.0)):
        at = int(back[0])
        raise GpsecError(
            f"{where}: sample {at + 2}: expected times that ascend, found {time_s[at + 1]:.3f} s after"
            f" {time_s[at]:.3f} s"
        )


def _check_pose(log: DriveLog) -> None:
    time_s, pose = log.pose.time_s, log.pose.numbers
    lasts_s = float(time_s[-1] - time_s[0])
    if not MIN_DRIVE_S <= lasts_s <= MAX_DRIVE_S:
        raise GpsecError(
            f"{log.source}: pose: expected a drive of {MIN_DRIVE_S:g} to {MAX_DRIVE_S:g} s, found {lasts_s:.1f} s"
        )
    gap_s = np.diff(time_s)
    at = int(gap_s.argmax())
    if gap_s[at] > MAX_POSE_GAP_S:
        raise GpsecError(
            f"{log.source}: pose: expected gaps of at most {MAX_POSE_GAP_S:g} s, found one of {gap_s[at]:.2f} s behind"
            f" {time_s[at]:.2f} s; cut the log there"
        )
    way_m = np.hypot(*np.diff(pose[:, :2], axis=0).T)
    if len(fast := np.flatnonzero(way_m > _FASTEST_MPS * gap_s + 1.0)):
        raise GpsecError(
            f"{log.source}: pose: sample {fast[0] + 2}: expected a drive, found a jump of {way_m[fast[0]]:.1f} m in"
            f" {gap_s[fast[0]]:.3f} s"
        )
    if way_m.sum() < MIN_WAY_M:
        raise GpsecError(
            f"{log.source}: pose: expected a way of at least {MIN_WAY_M:g} m, found {way_m.sum():.1f} m; positions are"
            " in metres, longitudes and latitudes have columns of their own"
        )


def _check_fixes(log: DriveLog) -> None:
    if log.fixes is None:
        return
    at = log.fixes.valid_s
    inside = (at >= log.pose.time_s[0]) & (at <= log.pose.time_s[-1])
    if inside.sum() < 2:
        raise GpsecError(
            f"{log.source}: fix: expected fixes in the time of the pose, {log.pose.time_s[0]:g} to"
            f" {log.pose.time_s[-1]:g} s, found {int(inside.sum())}"
        )
    there = np.column_stack([np.interp(at[inside], log.pose.time_s, axis) for axis in log.pose.numbers[:, :2].T])
    off_m = float(np.median(np.hypot(*(log.fixes.position_m[inside] - there).T)))
    if off_m > 1000.0:
        raise GpsecError(
            f"{log.source}: fix: expected fixes in the frame of the pose, found them {off_m:.0f} m away;"
            " east comes before north, and longitude before latitude"
        )


def _check_units(log: DriveLog) -> None:
    """Compare what a log says twice: the yaw and the course, the yaw rate and the turn, the speed and the way."""
    time_s, (east, north, yaw) = log.pose.time_s, log.pose.numbers.T
    step_s = np.maximum(np.diff(time_s), 1e-6)
    moving = np.hypot(np.diff(east), np.diff(north)) / step_s > _MOVING_MPS
    if moving.sum() > 10:
        _check_course(log, "pose", _angle(yaw[1:] - np.arctan2(np.diff(north), np.diff(east)))[moving])
    if log.heading is not None:
        known = np.interp(log.heading.time_s, time_s, np.unwrap(yaw))
        _check_course(log, "heading", _angle(log.heading.numbers[:, 0] - known))
    if log.speed is not None:
        way_m = float(np.hypot(np.diff(east), np.diff(north)).sum())
        _check_ratio(log, "speed", float(np.trapezoid(*_inside(log, log.speed))), way_m, "metres a second")
    if log.yaw_rate is not None:
        rate, at = _inside(log, log.yaw_rate)
        turn = np.interp(at, time_s, np.unwrap(yaw))
        known = np.gradient(turn, np.maximum.accumulate(at + 1e-9 * np.arange(len(at))))
        _check_rate(log, rate, np.clip(known, -pi, pi))


def _inside(log: DriveLog, samples: Samples) -> tuple[Floats, Floats]:
    """Return values and times of the samples in the time of the pose."""
    kept = (samples.time_s >= log.pose.time_s[0]) & (samples.time_s <= log.pose.time_s[-1])
    return samples.numbers[kept, 0], samples.time_s[kept]


def _check_course(log: DriveLog, name: str, off_rad: Floats) -> None:
    off = float(np.median(np.abs(off_rad)))
    if off > _COURSE_RAD:
        raise GpsecError(
            f"{log.source}: {name}: expected a yaw in radians, counter-clockwise from east, found one that is"
            f" {degrees(off):.0f}° off the course; degrees have columns called yaw_deg and heading_deg, and a compass"
            " has another zero"
        )


def _check_ratio(log: DriveLog, name: str, found: float, known: float, unit: str) -> None:
    if not 1.0 / _FACTOR < found / known < _FACTOR:
        raise GpsecError(
            f"{log.source}: {name}: expected {unit}, found values that are {found / known:.3g} times what the pose says"
        )


def _check_rate(log: DriveLog, rate_rps: Floats, known_rps: Floats) -> None:
    """Compare a yaw rate with the pose's: on average, and where the vehicle turns, over what both can follow."""
    off_rps = float(rate_rps.mean() - known_rps.mean())
    if abs(off_rps) > _MOST_BIAS_RPS:
        raise GpsecError(
            f"{log.source}: yaw_rate: expected radians a second, counter-clockwise, found values that are {off_rps:.3g}"
            " rad/s off the pose on average; degrees a second have a column called yaw_rate_dps"
        )
    width = max(len(rate_rps) // 200, 1)
    window = np.ones(width) / width
    smooth = [
        np.convolve(values, window, "valid") for values in (rate_rps - rate_rps.mean(), known_rps - known_rps.mean())
    ]
    turning: Flags = np.abs(smooth[1]) > _TURNING_RPS
    if turning.sum() < 20:
        return
    slope = float(smooth[0][turning] @ smooth[1][turning] / (smooth[1][turning] @ smooth[1][turning]))
    if not 1.0 / 3.0 < slope < 3.0:
        raise GpsecError(
            f"{log.source}: yaw_rate: expected radians a second, counter-clockwise, found values that are {slope:.3g}"
            " times what the pose says; degrees a second have a column called yaw_rate_dps"
        )


def _angle(angle_rad: Floats) -> Floats:
    wrapped: Floats = (angle_rad + pi) % (2.0 * pi) - pi
    return wrapped
