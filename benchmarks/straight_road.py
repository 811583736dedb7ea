"""Vehicles on a straight marked road, without SUMO: the monitor and the sensors of one profile, and nothing else."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.monitor import Monitor
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Pending
from gpsec.filters.noise import FilterNoise, noise_of
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

STEP_S, SPEED_MPS, SETTLE_S = 0.1, 12.0, 120.0
# Time on one road.
ROAD_S = 30.0
# How far variances are learnt: beside the two presets, not at all.
RULES = {"fixed": (1.0, 0.0), **PRESETS}


@dataclass
class Fleet:
    """Vehicles that drive east, with sensor errors of one profile.

    Attributes:
        figures: of their sensors as they are.
        rules: of their monitors, with the figures that these know.
        count: how many.
        seed: of all noise.
    """

    figures: FilterNoise[float]
    rules: MonitorRules
    count: int
    seed: int

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        f, n = self.figures, self.count
        self._monitor = Monitor(self.rules)
        for table in self._monitor.tables:
            table.grow(n)
        self._tracks, self._seen = Table(Tracks, n).now, Table(Measurements, n).now
        self._vehicles, self._pending = Table(Vehicles, n).now, Table(Pending, n).now
        self._rows = np.arange(n, dtype=np.int32)
        self._tracks.vehicle[:] = self._rows
        self._tracks.lane_known[:] = self._tracks.fix_valid[:] = self._tracks.residual_valid[
            :
        ] = self._seen.camera_valid[:] = True
        known = noise_of(self.rules.noise, 0)
        stated = np.sqrt(known.camera_white_m**2 + known.camera_bias_m**2 + known.camera_mount_m**2)
        self._pending.sigma_m[:] = stated
        self._scale = self._rng.normal(0.0, f.odometer_scale, n)
        self._gyro = self._rng.normal(0.0, f.gyro_bias_rps, n)
        self._mount = self._rng.normal(0.0, f.camera_mount_m, n)
        self._camera = self._rng.normal(0.0, f.camera_bias_m, n)
        self._gnss = self._rng.normal(0.0, f.gnss_bias_m, (n, 2))
        self._way_m, self._number, self._map = 0.0, 0, np.zeros(n)
        self._seen.heading_rad[:] = self._rng.normal(0.0, f.heading_rad, n)

    def _wander(self, value: Floats, sigma: float, tau_s: float) -> Floats:
        decay = np.exp(-STEP_S / tau_s)
        moved: Floats = decay * value + self._rng.normal(0.0, sigma * np.sqrt(1.0 - decay**2), value.shape)
        return moved

    def step(self, off_m: float = 0.0, dither: float = 0.0, map_m: float = 0.0) -> Floats:
        """Drive a step; return the (count,) statistics of `joint`.

        Args:
            off_m: by which fixes are off to the left.
            dither: standard deviation of the noise that is added to them, in those of their white noise.
            map_m: standard deviation of a map error across the road, drawn for each vehicle every `ROAD_S`.
        """
        f, n = self.figures, self.count
        self._way_m += SPEED_MPS * STEP_S
        self._gnss = self._wander(self._gnss, f.gnss_bias_m, f.gnss_bias_tau_s)
        self._camera = self._wander(self._camera, f.camera_bias_m, f.camera_bias_tau_s)
        self._gyro = self._wander(self._gyro, f.gyro_bias_rps, f.gyro_bias_tau_s)
        white_m = self._rng.normal(0.0, f.gnss_white_m * np.hypot(1.0, dither), (n, 2))
        self._tracks.fix_m[:] = self._gnss + white_m + (self._way_m, off_m)
        seen_m = self._camera + self._mount + self._rng.normal(0.0, f.camera_white_m, n)
        if self._number % round(ROAD_S / STEP_S) == 0:
            self._map = self._rng.normal(0.0, map_m, n)
            self._pending.lane[:] += 1
        self._tracks.residual_m[:] = seen_m - self._tracks.fix_m[:, 1] - self._map
        self._seen.speed_mps[:] = SPEED_MPS * (1.0 + self._scale) + self._rng.normal(0.0, f.odometer_white_mps, n)
        self._seen.yaw_rate_rps[:] = self._gyro + self._rng.normal(0.0, f.gyro_white_rps, n)
        seen = self._tracks, self._vehicles, self._seen
        told = self._monitor.update(self._number, self._pending, self._rows, *seen, Threads(1))
        self._number += 1
        return told.joint
