"""What a log says of each sensor, beside what a profile says: the table `errors.csv`."""

from collections.abc import Iterator
from math import degrees, nan, pi, sqrt

import numpy as np
import pandas as pd

from gpsec.replay.errors import ErrorSeries, fix_errors, speed_errors, yaw_rate_errors
from gpsec.replay.log import DriveLog
from gpsec.replay.statistics import (
    LAGS_S,
    LogFigure,
    autocorrelation,
    average,
    deviation,
    fit_wander,
    root_mean_square,
    root_structure,
    root_structures,
)
from gpsec.sensors.profiles import SensorProfile

ERROR_COLUMNS = (
    "scenario",
    "sensor",
    "axis",
    "figure",
    "unit",
    "value",
    "value_lo",
    "value_hi",
    "n",
    "profile_says",
    "key",
)
_FEWEST_LAGS = 4
_AXES = ("across", "along")


def error_table(log: DriveLog, scenario: str, profile: SensorProfile) -> pd.DataFrame:
    """Return a row for each figure: value with interval, number of samples, and what the profile says of the same.

    `key` is the key of the profile that says it, empty where none does.
    """
    rows = [*_of_fixes(log, profile), *_of_speed(log, profile), *_of_yaw_rate(log, profile), *_of_lane(log, profile)]
    return pd.DataFrame([(scenario, *row) for row in rows], columns=list(ERROR_COLUMNS))


_FigureRow = tuple[str, str, str, str, float, float, float, int, float, str]


def _row(
    place: tuple[str, str, str, str], found: LogFigure | float, number: int, says: float = nan, key: str = ""
) -> _FigureRow:
    """Return a row; `place` is sensor, axis, figure and unit."""
    figure = found if isinstance(found, LogFigure) else LogFigure(found, nan, nan)
    return (*place, figure.value, figure.low, figure.high, number, says, key)


def _of_fixes(log: DriveLog, profile: SensorProfile) -> Iterator[_FigureRow]:
    series = fix_errors(log)
    if series is None:
        return
    gnss, number = profile.gnss, int((~series.missing).sum())
    yield _row(("gnss", "", "rate", "Hz"), series.rate_hz, number, gnss.rate_hz, "gnss.rate_hz")
    yield _row(("gnss", "", "missing", "share"), _missing(series), len(series.missing))
    fixes = log.fixes
    if fixes is not None and (fixes.time_s != fixes.valid_s).any():
        age_s = float(np.mean(fixes.time_s - fixes.valid_s))
        yield _row(("gnss", "", "latency", "s"), age_s, number, gnss.latency_s, "gnss.latency_s")
    first = root_structures(series, 1.0 / series.rate_hz)
    for place, axis in enumerate(_AXES):
        values, changes = series.across_and_along()[:, place], series.changes()[:, place]
        yield _row(("gnss", axis, "mean", "m"), average(series, values), number)
        yield _row(("gnss", axis, "rms", "m"), root_mean_square(series, values), number, _slow(profile), "gnss.bias_m")
        yield _row(("gnss", axis, "sd in the drive", "m"), root_mean_square(series, changes), number)
        fix_to_fix = first[place]
        half = LogFigure(*(value / sqrt(2.0) for value in (fix_to_fix.value, fix_to_fix.low, fix_to_fix.high)))
        yield _row(("gnss", axis, "fix to fix / √2", "m"), half, number, gnss.white_m, "gnss.white_m")
        yield from _structure(series, place, profile)


def _structure(series: ErrorSeries, place: int, profile: SensorProfile) -> Iterator[_FigureRow]:
    axis = _AXES[place]
    number = int((~series.missing).sum())
    found = {lag: root_structures(series, lag)[place] for lag in LAGS_S if lag * series.rate_hz >= 0.999}
    for lag, figure in found.items():
        says = sqrt(profile.gnss.structure_m2(lag))
        yield _row(("gnss", axis, f"√structure {lag:g} s", "m"), figure, number, says, "gnss")
    known = {lag: one.value for lag, one in found.items() if one.value > 0.0}
    if len(known) < _FEWEST_LAGS:
        return
    fit = fit_wander(np.array(list(known)), np.array(list(known.values())))
    wander = fit.wander
    for name, unit, value in (
        ("fit: white_m", "m", fit.white_m),
        ("fit: wander_mps", "m/s", wander.rate_mps),
        ("fit: wander_tau_s", "s", wander.rate_tau_s),
        ("fit: wander_hold_s", "s", wander.hold_s),
        ("fit: worst ratio", "", fit.worst_ratio),
    ):
        yield _row(("gnss", axis, name, unit), value, number)


def _slow(profile: SensorProfile) -> float:
    return sqrt(profile.gnss.white_m**2 + profile.gnss.bias_m**2)


def _missing(series: ErrorSeries) -> float:
    return float(series.missing.mean())


def _of_speed(log: DriveLog, profile: SensorProfile) -> Iterator[_FigureRow]:
    found = speed_errors(log)
    if found is None:
        return
    series, factor = found
    odometer, values, number = profile.odometer, series.errors[:, 0], len(series.errors)
    yield _row(("odometer", "", "scale - 1", ""), factor - 1.0, number, odometer.scale_ratio, "odometer.scale_ratio")
    yield _row(
        ("odometer", "", "sd", "m/s"), deviation(series, values), number, odometer.white_mps, "odometer.white_mps"
    )
    step = root_structure(series, values, 0.1)
    half = LogFigure(*(value / sqrt(2.0) for value in (step.value, step.low, step.high)))
    yield _row(("odometer", "", "sample to sample / √2", "m/s"), half, number, odometer.white_mps, "odometer.white_mps")
    yield _row(("odometer", "", "autocorrelation 0.1 s", ""), autocorrelation(series, values, 0.1), number, 0.0)


def _of_yaw_rate(log: DriveLog, profile: SensorProfile) -> Iterator[_FigureRow]:
    series = yaw_rate_errors(log)
    if series is None:
        return
    gyro, values, number = profile.gyro, series.errors[:, 0], len(series.errors)
    per_hour = degrees(1.0) * 3600.0
    mean = average(series, values)
    bias = LogFigure(*(value * per_hour for value in (mean.value, mean.low, mean.high)))
    yield _row(("gyro", "", "bias", "°/h"), bias, number, gyro.bias_deg_per_h, "gyro.bias_deg_per_h")
    # The Allan deviation of a second is σ of the angle random walk over a second.
    second = np.add.reduceat(values, np.arange(0, len(values) - 9, 10))[: len(values) // 10] / 10.0
    allan = float(np.sqrt(0.5 * np.mean(np.diff(second) ** 2))) if len(second) > 2 else nan
    says = gyro.angle_random_walk_deg_per_sqrt_h
    walk = allan * 60.0 * 180.0 / pi
    key = "gyro.angle_random_walk_deg_per_sqrt_h"
    yield _row(("gyro", "", "angle random walk, with the pose's", "°/√h"), walk, number, says, key)


def _of_lane(log: DriveLog, profile: SensorProfile) -> Iterator[_FigureRow]:
    """Yield what a camera says of itself: without a map, that is from frame to frame only."""
    if log.lane is None:
        return
    time_s, c0 = log.lane.time_s, log.lane.numbers[:, 0]
    usual_s = float(np.median(np.diff(time_s)))
    follows = (np.diff(time_s) < 1.5 * usual_s) & (np.abs(np.diff(c0)) < 1.0)
    number = int(follows.sum())
    frame = float(np.sqrt(np.mean(np.diff(c0)[follows] ** 2) / 2.0)) if number else nan
    white_m = profile.camera.white_m
    yield _row(("camera", "", "rate", "Hz"), 1.0 / usual_s, number, profile.camera.rate_hz, "camera.rate_hz")
    yield _row(("camera", "", "C0 frame to frame / √2", "m"), frame, number, white_m, "camera.white_m")
    whole_s = float(time_s[-1] - time_s[0])
    lost = max(1.0 - len(time_s) * usual_s / whole_s, 0.0) if whole_s > 0.0 else nan
    says = min(profile.camera.outages_per_h * profile.camera.outage_mean_s / 3600.0, 1.0)
    yield _row(("camera", "", "missing", "share"), lost, len(time_s), says, "camera.outages_per_h")
