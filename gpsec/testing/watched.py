"""What the monitor says of residuals: vehicles that drive east in the middle of their lane, whose fixes are off it."""

from dataclasses import replace

import numpy as np

from gpsec.core.tables import Table, taken
from gpsec.core.threads import Threads
from gpsec.detection.channels import Channels, silent_channels
from gpsec.detection.logs import Grid, ResidualLog
from gpsec.detection.monitor import Monitor
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Pending
from gpsec.filters.noise import FilterNoise, noise_table
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

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
    camera_bias_m=0.02,
    camera_bias_tau_s=10.0,
    camera_mount_m=0.02,
    camera_period_s=0.1,
    gyro_latency_s=0.0,
)


def watched(grid: Grid) -> Grid:
    """Return residuals with what the monitor says of them."""
    return replace(grid, channels=_channels_of(grid))


def watched_log(log: ResidualLog) -> ResidualLog:
    """Return a log of vehicles of one length with what the monitor says."""
    channels = _channels_of(Grid.of([log]))
    flat = Channels._make(array.T.reshape(-1) for array in channels)
    return replace(log, channels=taken(flat, np.arange(len(log.vehicle), dtype=np.int32)))


def _channels_of(grid: Grid) -> Channels:
    """Return the (T, n) channels of residuals; there is a fix wherever there is a residual."""
    steps, vehicles = grid.valid.shape
    monitor = Monitor(MonitorRules(grid.step_s, noise_table([_FIGURES]), *PRESETS["R2"]), looks_back=True)
    for table in monitor.tables:
        table.grow(vehicles)
    tracks, pending = Table(Tracks, vehicles).now, Table(Pending, vehicles).now
    seen, truth = Table(Measurements, vehicles).now, Table(Vehicles, vehicles).now
    tracks.vehicle[:], tracks.lane_known[:] = np.arange(vehicles), True
    channels, threads = silent_channels((steps, vehicles)), Threads(1)
    for t in range(steps):
        rows = np.arange(grid.active(t), dtype=np.int32)
        tracks.residual_m[:], tracks.residual_valid[:] = grid.residual_m[t], grid.valid[t]
        seen.camera_valid[:] = tracks.fix_valid[:] = grid.valid[t]
        tracks.fix_m[:, 1] = -grid.residual_m[t]
        seen.speed_mps[:], pending.sigma_m[:] = grid.speed_mps[t], grid.camera_sigma_m[t]
        told = monitor.update(t, pending, rows, tracks, truth, seen, threads)
        for whole, part in zip(channels, told, strict=True):
            whole[t, : len(rows)] = part
        tracks.fix_m[:, 0] += grid.speed_mps[t] * grid.step_s
    return channels
