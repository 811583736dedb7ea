"""False alarms of `joint` on cars that are noisier than their data sheet: ``python -m benchmarks.honest_hours``.

Honest vehicles on a straight marked road, without SUMO, with the sensors of a profile, in worlds that their monitors do
not know. So many hours cost seconds, and show rates that no traffic is long enough for; curves, junctions and lane
changes are `benchmarks.joint`'s matter.
"""

import argparse

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table as PlainTable

from benchmarks.straight_road import RULES, SETTLE_S, STEP_S, Fleet
from gpsec.core.arrays import Floats
from gpsec.detection.models import gates_for
from gpsec.detection.monitor_state import MonitorRules
from gpsec.filters.noise import FilterNoise, noise_of, noise_table
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.sensors.registry import PROFILES

# Factor on the GNSS noise, on the camera's, map error (m).
WORLDS = {
    "as stated": (1.0, 1.0, 0.0),
    "GNSS noise × 1.5": (1.5, 1.0, 0.0),
    "camera noise × 1.5": (1.0, 1.5, 0.0),
    "map error N(0, 0.1 m) a road": (1.0, 1.0, 0.1),
    "map error N(0, 0.2 m) a road": (1.0, 1.0, 0.2),
}
VEHICLES = 200


def worse(figures: FilterNoise[float], gnss: float, camera: float) -> FilterNoise[float]:
    """Return figures of sensors that are noisier by some factors."""
    return figures._replace(
        gnss_white_m=gnss * figures.gnss_white_m,
        gnss_bias_m=gnss * figures.gnss_bias_m,
        camera_white_m=camera * figures.camera_white_m,
        camera_bias_m=camera * figures.camera_bias_m,
        camera_mount_m=camera * figures.camera_mount_m,
    )


def alarms_per_h(fleet: Fleet, hours: float, map_m: float, thresholds: Floats) -> Floats:
    """Return alarms that begin an hour, for each of the thresholds."""
    before = np.ones((len(thresholds), fleet.count), np.bool_)
    begun = np.zeros(len(thresholds))
    for number in range(round((SETTLE_S + hours * 3600.0 / fleet.count) / STEP_S)):
        alarm = fleet.step(map_m=map_m) > thresholds[:, np.newaxis]
        if number * STEP_S >= SETTLE_S:
            begun += (alarm & ~before).sum(axis=1)
        before = alarm
    rate: Floats = begun / hours
    return rate


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.honest_hours", description=__doc__)
    parser.add_argument("--profile", default="carla", choices=list(PROFILES))
    parser.add_argument("--hours", type=float, default=200.0, metavar="H", help="vehicle-hours of each row")
    parser.add_argument("--thresholds", nargs="+", type=float, default=[24.0, 33.0, 41.0], metavar="T")
    parser.add_argument("--seed", type=int, default=11, metavar="N")
    options = parser.parse_args()
    table = noise_table([filter_noise(PROFILES[options.profile], STEP_S)])
    gate = gates_for([options.profile], "tracked")
    drawn = PlainTable("world", "variances", *(f"T > {threshold:g}" for threshold in options.thresholds))
    cases = [(world, name) for world in WORLDS for name in RULES]
    for world, name in track(cases, console=Console(stderr=True)):
        gnss, camera, map_m = WORLDS[world]
        rules = MonitorRules(STEP_S, table, gate, *RULES[name])
        fleet = Fleet(worse(noise_of(table, 0), gnss, camera), rules, VEHICLES, options.seed)
        rates = alarms_per_h(fleet, options.hours, map_m, np.array(options.thresholds))
        drawn.add_row(world, name, *(f"{rate:.2f}" for rate in rates))
    Console().print(drawn)


if __name__ == "__main__":
    main()
