"""`gpsec stress`: a scenario in worlds that filters and detectors do not know, one after the other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from gpsec.core.progress import Progress, Report
from gpsec.outcomes.tables import FLOAT_FORMAT, whole
from gpsec.paper.runs import RUNS, run_missing
from gpsec.paper.stress_table import stress_rows
from gpsec.scenario import Scenario
from gpsec.scenario.choices import BOUNDS
from gpsec.scenario.detection import Defence
from gpsec.scenario.load import changed
from gpsec.scenario.model import MAX_NAME
from gpsec.scenario.overrides import Override
from gpsec.types.points import HEADLINE_RATE, detector_at

TABLE_OF_STRESS = "stress.csv"
# What stands behind a detector of which the scenario has no defence.
_RESPONSE = "ukf"


@dataclass(frozen=True)
class Factor:
    """One way in which the world differs from what is known of it.

    Attributes:
        title: in tables and figures.
        world: keys of `[world]`.
    """

    title: str
    world: Mapping[str, float]


FACTORS: Mapping[str, Factor] = {
    "nothing": Factor("nothing", {}),
    "gnss_1.5": Factor("GNSS noise × 1.5", {"gnss_white_factor": 1.5, "gnss_slow_factor": 1.5}),
    "gnss_2": Factor("GNSS noise × 2", {"gnss_white_factor": 2.0, "gnss_slow_factor": 2.0}),
    "camera_1.5": Factor("camera noise × 1.5", {"camera_factor": 1.5}),
    "camera_2": Factor("camera noise × 2", {"camera_factor": 2.0}),
    "camera_lanes": Factor(
        "camera errs about its lane", {"camera_wrong_per_h": 60.0, "camera_late_s": 0.5, "camera_blind_m": 0.6}
    ),
    "map_0.1": Factor("map off by 0.1 m", {"map_shift_north_m": 0.1}),
    "map_0.2": Factor("map off by 0.2 m", {"map_shift_north_m": 0.2}),
    "map_road_0.1": Factor("map error N(0, 0.1 m) a road", {"map_road_m": 0.1}),
    "map_road_0.2": Factor("map error N(0, 0.2 m) a road", {"map_road_m": 0.2}),
    "multipath_0.5": Factor("multipath, 0.5 m on 12 % of the road", {"multipath_share": 0.12, "multipath_m": 0.5}),
    "odometry": Factor("odometer × 2, gyro × 3", {"odometer_factor": 2.0, "gyro_factor": 3.0}),
    "gnss_common": Factor("slow GNSS error in common", {"gnss_common_share": 0.9}),
}
"""The rows of the table, by the names that the command line takes."""


def stressed(scenario: Scenario, factors: Sequence[str], seeds: Sequence[int]) -> dict[str, list[Scenario]]:
    """Return the runs of each factor, one for each seed; in them every detector has a defence at each of its rates."""
    known = {(defence.detector, defence.rate) for defence in scenario.defences}
    points = [point for point in scenario.points() if point[0] not in BOUNDS and point not in known]
    added = [Defence(detector=name, response=_RESPONSE, rate=rate) for name, rate in points]
    order = [*BOUNDS, *scenario.detection.detectors]
    defences = sorted(
        (*scenario.defences, *added), key=lambda one: (one.rate != HEADLINE_RATE, one.rate, order.index(one.detector))
    )
    whole_scenario = scenario.model_copy(update={"defences": tuple(defences)})
    made: dict[str, list[Scenario]] = {}
    for factor in factors:
        keys = [Override(("world", key), value, f"factor {factor}") for key, value in FACTORS[factor].world.items()]
        one = changed(whole_scenario, keys)
        made[factor] = [
            one.model_copy(update={"seed": seed, "name": _name(scenario.name, f"-{factor}-{seed}")}) for seed in seeds
        ]
    return made


def _name(name: str, end: str) -> str:
    return name[: MAX_NAME - len(end)] + end


def run_stress(out: Path, runs: Mapping[str, Sequence[Scenario]], jobs: int, report: Report) -> pd.DataFrame:
    """Run what is missing in ``out/runs``, write the table to `out` and return it.

    Raises:
        GpsecError: a scenario cannot be run, or `out` cannot be written.
        KeyboardInterrupt: the user has had enough; the same call goes on from there.
    """
    folder = out / RUNS
    run_missing([scenario for members in runs.values() for scenario in members], folder, jobs, report)
    report(Progress("table", stage="pooling events"))
    rows = []
    for factor, members in runs.items():
        found = stress_rows([folder / scenario.name for scenario in members])
        rows.append(found.assign(factor=factor, title=FACTORS[factor].title))
    table = pd.concat(rows, ignore_index=True)
    table = table[["factor", "title", *(name for name in table.columns if name not in ("factor", "title"))]]
    with whole(out / TABLE_OF_STRESS) as partial:
        table.to_csv(partial, index=False, float_format=FLOAT_FORMAT, lineterminator="\n", encoding="utf-8")
    return table


def is_bound(point: str) -> bool:
    """Whether a detector of the table, which may be named with its rate, is no detector, but what frames them."""
    return detector_at(point) in BOUNDS
