"""What the monitor says of vehicles whose inputs are in a log, so that one log serves any gate."""

from dataclasses import replace

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.channels import silent_channels
from gpsec.detection.logs import Grid
from gpsec.detection.monitor import Monitor
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Pending
from gpsec.filters.noise import noise_table
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# The preset that thresholds are calibrated with.
_PRESET = "R2"


def monitored(grid: Grid, gate: float, threads: Threads | None = None, looks_back: bool = True) -> Grid:
    """Return a grid with what a monitor with a `gate` (inf: an open one) says, exactly as it would in the loop.

    Raises:
        GpsecError: the grid has not what the monitor is handed.
    """
    if grid.inputs is None or grid.figures is None:
        raise GpsecError("residual logs: expected what the monitor is handed, for detectors that read it; found none")
    steps, vehicles = grid.valid.shape
    rules = MonitorRules(grid.step_s, noise_table([grid.figures]), np.array([gate]), *PRESETS[_PRESET])
    monitor = Monitor(rules, looks_back)
    for table in monitor.tables:
        table.grow(vehicles)
    tracks, pending = Table(Tracks, vehicles).now, Table(Pending, vehicles).now
    seen, truth = Table(Measurements, vehicles).now, Table(Vehicles, vehicles).now
    tracks.vehicle[:], tracks.lane_known[:] = np.arange(vehicles), True
    channels = silent_channels((steps, vehicles))
    for step in range(steps):
        m = grid.active(step)
        given = type(grid.inputs)._make(array[step, :m] for array in grid.inputs)
        tracks.residual_m[:m], tracks.residual_valid[:m] = grid.residual_m[step, :m], grid.valid[step, :m]
        tracks.fix_m[:m, 0], tracks.fix_m[:m, 1] = given.fix_east_m, given.fix_north_m
        tracks.fix_valid[:m], tracks.unmatched[:m] = given.fix_valid, given.unmatched
        seen.speed_mps[:m], seen.yaw_rate_rps[:m] = grid.speed_mps[step, :m], given.yaw_rate_rps
        seen.heading_rad[:m], seen.camera_valid[:m] = given.heading_rad, given.sees_lane
        pending.sigma_m[:m], pending.lane[:m] = grid.camera_sigma_m[step, :m], given.lane
        rows = np.arange(m, dtype=np.int32)
        told = monitor.update(step, pending, rows, tracks, truth, seen, threads or Threads(1))
        for whole, part in zip(channels, told, strict=True):
            whole[step, :m] = part
    return replace(grid, channels=channels)
