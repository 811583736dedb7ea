"""What a patient attacker gains before the monitor's alarm: ``python -m benchmarks.patience``.

Vehicles on a straight marked lane, without SUMO, with the sensors of a profile. After some minutes of honest fixes,
the attacker moves them across the lane at a constant speed, for ten minutes at most; with *dither* it has first added
noise of its own for ten minutes, so that the vehicle takes its receiver for a bad one. What counts is how far fixes are
off at the first alarm (if there is none, at the end): the median over vehicles, at the speed that gains most.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table as PlainTable

from gpsec.core.arrays import Floats
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.monitor import MONITOR_GATE, Monitor
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Pending
from gpsec.filters.noise import FilterNoise, noise_of, noise_table
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.registry import PROFILES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

STEP_S, SPEED_MPS = 0.1, 12.0
SETTLE_S, DITHER_S, ATTACK_S = 120.0, 600.0, 600.0
SPEEDS_MPS = (0.001, 0.002, 0.004, 0.008, 0.015, 0.03, 0.06, 0.12)
# Beside the two presets, variances of the data sheet.
RULES = {"fixed": (1.0, 0.0), **PRESETS}


@dataclass
class Fleet:
    """Vehicles that drive east, with sensor errors of one profile.

    Attributes:
        figures: of their sensors.
        rules: of their monitors.
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
        self._pending.sigma_m[:] = np.sqrt(f.camera_white_m**2 + f.camera_bias_m**2 + f.camera_mount_m**2)
        self._scale = self._rng.normal(0.0, f.odometer_scale, n)
        self._gyro = self._rng.normal(0.0, f.gyro_bias_rps, n)
        self._mount = self._rng.normal(0.0, f.camera_mount_m, n)
        self._camera = self._rng.normal(0.0, f.camera_bias_m, n)
        self._gnss = self._rng.normal(0.0, f.gnss_bias_m, (n, 2))
        self._way_m, self._number = 0.0, 0
        self._seen.heading_rad[:] = self._rng.normal(0.0, f.heading_rad, n)

    def _wander(self, value: Floats, sigma: float, tau_s: float) -> Floats:
        decay = np.exp(-STEP_S / tau_s)
        moved: Floats = decay * value + self._rng.normal(0.0, sigma * np.sqrt(1.0 - decay**2), value.shape)
        return moved

    def step(self, off_m: float, dither: float) -> Floats:
        """Drive a step with fixes that are off to the left; return the (count,) statistics."""
        f, n = self.figures, self.count
        self._way_m += SPEED_MPS * STEP_S
        self._gnss = self._wander(self._gnss, f.gnss_bias_m, f.gnss_bias_tau_s)
        self._camera = self._wander(self._camera, f.camera_bias_m, f.camera_bias_tau_s)
        self._gyro = self._wander(self._gyro, f.gyro_bias_rps, f.gyro_bias_tau_s)
        white_m = self._rng.normal(0.0, f.gnss_white_m * np.hypot(1.0, dither), (n, 2))
        self._tracks.fix_m[:] = self._gnss + white_m + (self._way_m, off_m)
        seen_m = self._camera + self._mount + self._rng.normal(0.0, f.camera_white_m, n)
        self._tracks.residual_m[:] = seen_m - self._tracks.fix_m[:, 1]
        self._seen.speed_mps[:] = SPEED_MPS * (1.0 + self._scale) + self._rng.normal(0.0, f.odometer_white_mps, n)
        self._seen.yaw_rate_rps[:] = self._gyro + self._rng.normal(0.0, f.gyro_white_rps, n)
        seen = self._tracks, self._vehicles, self._seen
        told = self._monitor.update(self._number, self._pending, self._rows, *seen, Threads(1))
        self._number += 1
        return told.joint


def gained_m(fleet: Fleet, speed_mps: float, dither: float, threshold: float) -> Floats:
    """Return how far fixes of each vehicle are off at the first alarm, or in the end."""
    for _ in range(round(SETTLE_S / STEP_S)):
        fleet.step(0.0, 0.0)
    for _ in range(round(DITHER_S / STEP_S) if dither else 0):
        fleet.step(0.0, dither)
    caught = np.full(fleet.count, np.inf)
    for number in range(round(ATTACK_S / STEP_S)):
        off_m = speed_mps * STEP_S * number
        caught[(fleet.step(off_m, dither) > threshold) & np.isinf(caught)] = off_m
        if np.isfinite(caught).all():
            break
    gained: Floats = np.minimum(caught, off_m)
    return gained


def cases() -> Iterator[tuple[str, float, float]]:
    """Yield rules, dither in standard deviations of the white noise, and speed."""
    for name in RULES:
        for dither in (0.0, 1.0):
            for speed_mps in SPEEDS_MPS:
                yield name, dither, speed_mps


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.patience", description=__doc__)
    parser.add_argument("--profile", default="carla", choices=list(PROFILES))
    parser.add_argument("--vehicles", type=int, default=100, metavar="N")
    parser.add_argument(
        "--threshold", type=float, default=MONITOR_GATE, metavar="T", help="of the statistic of `joint`"
    )
    parser.add_argument("--seed", type=int, default=11, metavar="N")
    options = parser.parse_args()
    profile: SensorProfile = PROFILES[options.profile]
    noise = noise_table([filter_noise(profile, STEP_S)])
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for name, dither, speed_mps in track(list(cases()), console=Console(stderr=True)):
        rules = MonitorRules(STEP_S, noise, *RULES[name])
        fleet = Fleet(noise_of(noise, 0), rules, options.vehicles, options.seed)
        gained = float(np.median(gained_m(fleet, speed_mps, dither, options.threshold)))
        best[name, dither] = max(best.get((name, dither), (0.0, 0.0)), (gained, speed_mps))
    table = PlainTable("variances", "dither (σ)", "gained (m)", "at (m/s)")
    for (name, dither), (gained, speed_mps) in best.items():
        table.add_row(name, f"{dither:g}", f"{gained:.2f}", f"{speed_mps:g}")
    Console().print(table)


if __name__ == "__main__":
    main()
