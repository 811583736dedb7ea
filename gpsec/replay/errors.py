"""By how much each sensor of a log was off the pose, in the order of time and on a uniform clock."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Flags, Floats, Longs
from gpsec.replay.log import DriveLog, Samples

# Longer without a fix is no outage but the end of a piece.
_PIECE_GAP_S = 10.0


@dataclass(frozen=True)
class ErrorSeries:
    """Errors of one sensor, measured less true; L samples on a uniform clock in P pieces.

    Attributes:
        rate_hz: samples a second.
        errors: (L, k), 0 where missing.
        missing: (L,).
        yaw_rad: (L,) of the pose, for directions.
        piece: (P,) first sample of each piece.
    """

    rate_hz: float
    errors: Floats
    missing: Flags
    yaw_rad: Floats
    piece: Longs

    def across_and_along(self) -> Floats:
        """Return the (L, 2) errors across the way, left positive, and along it."""
        return across_along(self.errors, self.yaw_rad)

    def changes(self) -> Floats:
        """Return the same of what the errors are less their mean, which does not turn with the way."""
        return across_along(self.errors - self.errors[~self.missing].mean(axis=0), self.yaw_rad)


def across_along(east_north: Floats, yaw_rad: Floats) -> Floats:
    """Return (L, 2) vectors across directions, left positive, and along them."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
    east, north = east_north.T
    return np.column_stack([cosine * north - sine * east, cosine * east + sine * north])


def fix_errors(log: DriveLog) -> ErrorSeries | None:
    """Return the errors of fixes, east and north, each at the time for which it was true; None without a receiver."""
    if log.fixes is None:
        return None
    time_s, (east, north, yaw) = log.pose.time_s, log.pose.numbers.T
    inside = (log.fixes.valid_s >= time_s[0]) & (log.fixes.valid_s <= time_s[-1])
    at_s, position_m = log.fixes.valid_s[inside], log.fixes.position_m[inside]
    ascending = np.concatenate([[True], np.diff(np.maximum.accumulate(at_s)) > 0.0])
    at_s, position_m = at_s[ascending], position_m[ascending]
    true_m = np.column_stack([np.interp(at_s, time_s, east), np.interp(at_s, time_s, north)])
    yaw_rad = np.interp(at_s, time_s, np.unwrap(yaw))
    return _uniform(at_s, position_m - true_m, yaw_rad)


def _uniform(at_s: Floats, errors: Floats, yaw_rad: Floats) -> ErrorSeries:
    """Return samples on the clock of their usual distance, with a mask for those that are not there."""
    usual_s = float(np.median(np.diff(at_s)))
    rate_hz = round(1.0 / usual_s, 3)
    parts, starts, total = [], [], 0
    breaks = np.flatnonzero(np.diff(at_s) > _PIECE_GAP_S) + 1
    for part in np.split(np.arange(len(at_s)), breaks):
        place = np.rint((at_s[part] - at_s[part[0]]) * rate_hz).astype(np.int64)
        length = int(place[-1]) + 1
        made = np.zeros((length, errors.shape[1] + 2))
        made[:, -1] = 1.0
        made[place, :-2], made[place, -2], made[place, -1] = errors[part], yaw_rad[part], 0.0
        parts.append(made)
        starts.append(total)
        total += length
    joined = np.concatenate(parts)
    return ErrorSeries(rate_hz, joined[:, :-2], joined[:, -1] > 0.0, joined[:, -2], np.array(starts, np.int64))


def speed_errors(log: DriveLog) -> tuple[ErrorSeries, float] | None:
    """Return the errors of the wheels' speed (m/s) and their factor; a factor is no error here. None without wheels.

    Errors are what is left of speed = factor · true speed, ten times a second, at the lag at which least is left.
    """
    if log.speed is None:
        return None
    at_s, true_mps = _true_speed(log)
    tried = []
    for lag_s in np.arange(-0.3, 0.31, 0.02):
        found = _means(log.speed, at_s + lag_s)
        factor = float(found @ true_mps / (true_mps @ true_mps))
        tried.append((factor, found - factor * true_mps))
    factor, left = min(tried, key=lambda one: float(one[1].std()))
    none = np.zeros(len(left))
    return ErrorSeries(1.0 / _GRAIN_S, left[:, None], none > 0.0, none, np.zeros(1, np.int64)), factor


_GRAIN_S = 0.1


def _true_speed(log: DriveLog) -> tuple[Floats, Floats]:
    """Return times, and the pose's mean speed over the tenth of a second about each."""
    time_s, (east, north, _) = log.pose.time_s, log.pose.numbers.T
    edge_s = np.arange(time_s[0] + 0.5, time_s[-1] - 0.5, _GRAIN_S)
    way = [np.diff(np.interp(edge_s, time_s, axis)) for axis in (east, north)]
    return 0.5 * (edge_s[1:] + edge_s[:-1]), np.hypot(*way) / _GRAIN_S


def _means(samples: Samples, at_s: Floats) -> Floats:
    """Return the mean of what a sensor said over the tenth of a second about each time."""
    values = samples.numbers[:, 0]
    total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(samples.time_s))])
    half = 0.5 * _GRAIN_S
    ends, begins = (np.interp(at_s + side, samples.time_s, total) for side in (half, -half))
    means: Floats = (ends - begins) / _GRAIN_S
    return means


def yaw_rate_errors(log: DriveLog) -> ErrorSeries | None:
    """Return the errors of the gyro (rad/s), ten times a second; None without one."""
    if log.yaw_rate is None:
        return None
    time_s, yaw = log.pose.time_s, np.unwrap(log.pose.numbers[:, 2])
    edge_s = np.arange(time_s[0] + 0.5, time_s[-1] - 0.5, _GRAIN_S)
    true_rps = np.diff(np.interp(edge_s, time_s, yaw)) / _GRAIN_S
    left = _means(log.yaw_rate, 0.5 * (edge_s[1:] + edge_s[:-1])) - true_rps
    none = np.zeros(len(left))
    return ErrorSeries(1.0 / _GRAIN_S, left[:, None], none > 0.0, none, np.zeros(1, np.int64))
