"""What the monitor says of residuals: vehicles that drive east in the middle of their lane, whose fixes are off it."""

from dataclasses import replace

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.detection.logs import Grid, ResidualLog
from gpsec.detection.monitor_state import MonitorInputs
from gpsec.detection.monitored import monitored
from gpsec.filters.noise import FilterNoise

_GATE = 41.0
# GNSS like the residuals of `gpsec.testing.residuals`; hardly any error of all else.
_FIGURES = FilterNoise(
    gnss_white_m=0.15,
    gnss_bias_m=0.24,
    gnss_bias_tau_s=60.0,
    gnss_period_s=0.1,
    odometer_white_mps=0.05,
    odometer_scale=0.005,
    gyro_white_rps=0.001,
    gyro_bias_rps=1e-5,
    heading_rad=0.003,
    residual_m=0.3,
    gyro_bias_tau_s=100.0,
    camera_white_m=0.05,
    camera_slope=0.01,
    camera_slope_correlation=0.0,
    camera_bias_m=0.02,
    camera_bias_tau_s=10.0,
    camera_mount_m=0.02,
    camera_period_s=0.1,
    gyro_latency_s=0.0,
)


def watched(grid: Grid) -> Grid:
    """Return residuals with what the monitor says of them."""
    inputs = _inputs_of(grid.residual_m, grid.valid, grid.speed_mps * grid.step_s)
    return replace(monitored(replace(grid, inputs=inputs, figures=_FIGURES), _GATE), inputs=None)


def watched_log(log: ResidualLog) -> ResidualLog:
    """Return a log of vehicles of one length with what the monitor is handed."""
    grid = Grid.of([log])
    inputs = _inputs_of(grid.residual_m, grid.valid, grid.speed_mps * grid.step_s)
    flat = MonitorInputs._make(array.T.reshape(-1) for array in inputs)
    return replace(log, inputs=flat, figures=_FIGURES)


def _inputs_of(residual_m: Floats, valid: Flags, way_m: Floats) -> MonitorInputs:
    """Return the (T, n) inputs; there is a fix wherever there is a residual."""
    nothing, lane = np.zeros(valid.shape), np.zeros(valid.shape, np.int32)
    east_m = np.cumsum(way_m, axis=0) - way_m
    return MonitorInputs(east_m, -residual_m, valid, nothing, nothing, lane, valid, np.zeros(valid.shape, np.bool_))
