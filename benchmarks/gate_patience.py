"""How far a patient attacker moves a vehicle that only refuses fixes: ``python -m benchmarks.gate_patience``.

Vehicles on a straight road with the response `gate`, without SUMO, with the sensors of a profile. After two minutes of
honest fixes, the attacker moves them across the road: at a constant speed for five minutes, or as `stealth` does for
one. With *dither* it has first added noise of its own for five minutes, so that the vehicle takes its receiver for a
bad one. What counts is the largest error across that the estimate comes to: the median over vehicles, of the attack
that gains most. Nobody is there to raise an alarm.
"""

import argparse
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table as PlainTable

from gpsec.core.arrays import Floats
from gpsec.filters.noise import FilterNoise
from gpsec.localization.gated import LEARNT_NOISE
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.sensors.registry import PROFILES
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import Rig, straight_road

SETTLE_S, DITHER_S, ATTACK_S, MOST_M = 120.0, 300.0, 300.0, 10.0
SPEEDS_MPS = (0.01, 0.02, 0.04, 0.08, 0.16, 0.32)
GROWTHS = (1.01, 1.02, 1.05, 1.1)
# Shift (m) at a time (s), for so long.
Attack = tuple[Callable[[float], float], float]


class GatedFleet:
    """Vehicles that drive east behind a gate, with sensor errors of one profile."""

    def __init__(self, figures: FilterNoise[float], count: int, seed: int, factor: float) -> None:
        """Begin; the white noise of fixes is by a factor larger than their filters know."""
        self._f, self._rng, self._white_m = figures, np.random.default_rng(seed), factor * figures.gnss_white_m
        self._rig = Rig(straight_road(), responses=("gate",), count=count, figures=figures, speed_mps=12.0)
        self._scale = self._rng.normal(0.0, figures.odometer_scale, count)
        self._gyro = self._rng.normal(0.0, figures.gyro_bias_rps, count)
        self._gnss = self._rng.normal(0.0, figures.gnss_bias_m, (count, 2))
        self._rig.seen.heading_rad[:] = self._rng.normal(0.0, figures.heading_rad, count)

    def _wander(self, value: Floats, sigma: float, tau_s: float) -> Floats:
        decay = np.exp(-STEP_S / tau_s)
        moved: Floats = decay * value + self._rng.normal(0.0, sigma * np.sqrt(1.0 - decay**2), value.shape)
        return moved

    def step(self, off_m: float, dither_m: float) -> Floats:
        """Drive a step with fixes that are off to the left, and noisier; return the (count,) errors across."""
        f, rig, n = self._f, self._rig, self._rig.count
        rig.vehicles.rear_m[:, 0] += rig.speed_mps * STEP_S
        self._gnss = self._wander(self._gnss, f.gnss_bias_m, f.gnss_bias_tau_s)
        self._gyro = self._wander(self._gyro, f.gyro_bias_rps, f.gyro_bias_tau_s)
        white_m = self._rng.normal(0.0, np.hypot(self._white_m, dither_m), (n, 2))
        rig.tracks.fix_m[:] = rig.vehicles.rear_m + self._gnss + white_m + (0.0, off_m)
        rig.tracks.fix_valid[:] = True
        odometer_mps = self._rng.normal(0.0, f.odometer_white_mps, n)
        rig.seen.speed_mps[:] = rig.speed_mps * (1.0 + self._scale) + odometer_mps
        rig.seen.yaw_rate_rps[:] = self._gyro + self._rng.normal(0.0, f.gyro_white_rps, n)
        rig.localize(rig.rows)
        across: Floats = rig.error_m("gate")[:, 1]
        return across

    @property
    def learnt(self) -> float:
        """The median factor that is learnt."""
        return float(np.median(np.exp(self._rig.filters("gate").mean[:, LEARNT_NOISE])))


def steady(speed_mps: float, time_s: float) -> float:
    """Return a shift at a constant speed."""
    return speed_mps * time_s


def growing(growth: float, time_s: float) -> float:
    """Return the shift of `stealth`."""
    return float(min(0.02 * growth ** (10.0 * time_s), MOST_M))


def attacks() -> Iterator[Attack]:
    """Yield none, constant speeds and exponential growth."""
    yield partial(steady, 0.0), ATTACK_S
    for speed_mps in SPEEDS_MPS:
        yield partial(steady, speed_mps), min(ATTACK_S, MOST_M / speed_mps)
    for growth in GROWTHS:
        yield partial(growing, growth), 60.0


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gate_patience", description=__doc__)
    parser.add_argument("--profile", default="carla", choices=list(PROFILES))
    parser.add_argument("--vehicles", type=int, default=40, metavar="N")
    parser.add_argument("--seed", type=int, default=11, metavar="N")
    options = parser.parse_args()
    figures = filter_noise(PROFILES[options.profile], STEP_S)
    table = PlainTable("GNSS noise", "dither (σ)", "learnt", "no attack (m)", "speed (m/s)", "(m)", "growth", "(m)")
    worlds = [(factor, dither) for factor in (1.0, 1.5) for dither in (0.0, 1.0)]
    for factor, dither in track(worlds, console=Console(stderr=True)):
        moved, learnt, added_m = [], 0.0, dither * figures.gnss_white_m
        for shift, lasts_s in attacks():
            fleet = GatedFleet(figures, options.vehicles, options.seed, factor)
            for lasts, dither_m in ((SETTLE_S, 0.0), (DITHER_S if dither else 0.0, added_m)):
                for _ in range(round(lasts / STEP_S)):
                    fleet.step(0.0, dither_m)
            learnt = fleet.learnt
            errors = [np.abs(fleet.step(shift(number * STEP_S), added_m)) for number in range(round(lasts_s / STEP_S))]
            moved.append(float(np.median(np.max(errors, axis=0))))
        ramps, grown = moved[1 : 1 + len(SPEEDS_MPS)], moved[1 + len(SPEEDS_MPS) :]
        table.add_row(
            *(f"{factor:g}", f"{dither:g}", f"{learnt:.2f}", f"{moved[0]:.2f}"),
            *(f"{SPEEDS_MPS[int(np.argmax(ramps))]:g}", f"{max(ramps):.2f}"),
            *(f"{GROWTHS[int(np.argmax(grown))]:g}", f"{max(grown):.2f}"),
        )
    Console().print(table)


if __name__ == "__main__":
    main()
