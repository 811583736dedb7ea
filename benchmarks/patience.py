"""What a patient attacker gains before the monitor's alarm: ``python -m benchmarks.patience``.

Vehicles on a straight marked lane, without SUMO, with the sensors of a profile. After some minutes of honest fixes,
the attacker moves them across the lane at a constant speed, for ten minutes at most; with *dither* it has first added
noise of its own for ten minutes, so that the vehicle takes its receiver for a bad one. What counts is how far fixes are
off at the first alarm (if there is none, at the end): the median over vehicles, at the speed that gains most.
"""

import argparse
from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table as PlainTable

from benchmarks.straight_road import RULES, SETTLE_S, STEP_S, Fleet
from gpsec.core.arrays import Floats
from gpsec.detection.models import gates_for
from gpsec.detection.monitor_state import MonitorRules
from gpsec.filters.noise import noise_of, noise_table
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.registry import PROFILES

DITHER_S, ATTACK_S = 600.0, 600.0
SPEEDS_MPS = (0.001, 0.002, 0.004, 0.008, 0.015, 0.03, 0.06, 0.12)


def gained_m(fleet: Fleet, speed_mps: float, dither: float, threshold: float) -> Floats:
    """Return how far fixes of each vehicle are off at the first alarm, or in the end."""
    for _ in range(round(SETTLE_S / STEP_S)):
        fleet.step()
    for _ in range(round(DITHER_S / STEP_S) if dither else 0):
        fleet.step(dither=dither)
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
        "--threshold", type=float, metavar="T", help="of the statistic of `joint`; by default the gate of the profile"
    )
    parser.add_argument("--seed", type=int, default=11, metavar="N")
    options = parser.parse_args()
    profile: SensorProfile = PROFILES[options.profile]
    noise = noise_table([filter_noise(profile, STEP_S)])
    gate = gates_for([profile.name], "tracked")
    threshold = float(gate[0]) if options.threshold is None else options.threshold
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for name, dither, speed_mps in track(list(cases()), console=Console(stderr=True)):
        rules = MonitorRules(STEP_S, noise, gate, *RULES[name])
        fleet = Fleet(noise_of(noise, 0), rules, options.vehicles, options.seed)
        gained = float(np.median(gained_m(fleet, speed_mps, dither, threshold)))
        best[name, dither] = max(best.get((name, dither), (0.0, 0.0)), (gained, speed_mps))
    table = PlainTable("variances", "dither (σ)", "gained (m)", "at (m/s)")
    for (name, dither), (gained, speed_mps) in best.items():
        table.add_row(name, f"{dither:g}", f"{gained:.2f}", f"{speed_mps:g}")
    Console().print(table)


if __name__ == "__main__":
    main()
