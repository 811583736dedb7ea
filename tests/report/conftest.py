"""A finished run made by hand: no SUMO, every figure has something to show, and names that HTML must not believe."""

import json
from pathlib import Path

import numpy as np
import pytest

from gpsec.core.geo import Projector
from gpsec.outcomes.steps import StepLog
from gpsec.running.results import Results, load
from tests.outcomes.scene import DEFENCES, DETECTORS, PROFILES, Scene

EVIL = "</script><img src=x onerror=\"document.title='broken'\">&amp;"
PLANS = ("none", "bias", "jamming", EVIL)
LANE_M = [[0.0, 0.0], [100.0, 0.0]]
NET = Projector("+proj=utm +zone=32 +datum=WGS84 +units=m", (-600_000.0, -5_790_000.0))


def write_run(folder: Path, scenario: str = "lane", *, error_m: float = 2.0, log: bool = True) -> Path:
    """Six vehicles that go east by 1 m a step of 0.1 s; each is attacked from step 20 to 60, two under each plan.

    Undefended they are off by `error_m` to the left from five steps after that on, and out of a lane of 3.5 m. CUSUM
    sees the bias after five steps, and nothing of the third plan. Jamming leaves nothing to score.
    """
    folder.mkdir(parents=True)
    scene = Scene(capacity=12, plan_names=PLANS, profile_names=PROFILES[:1])
    names = [EVIL, "b", "c", "d", "e", "f"]
    ids = names * 2
    steps = StepLog(folder / "steps.parquet", PLANS, DETECTORS, DEFENCES, ["e_0"], NET)
    for step in range(80):
        if step == 20:
            for vehicle in range(6):
                scene.fork(vehicle, 6 + vehicle, 1 + vehicle // 2, step)
        if step == 60:
            for vehicle in range(6):
                scene.end_attack(6 + vehicle, step)
        scene.vehicles.rear_m[:] = float(step), 0.0
        scene.tracks.fix_m[:] = scene.vehicles.rear_m
        scene.tracks.fix_valid[:] = True
        scene.seen.camera_valid[:] = True
        late = 25 <= step < 60
        scene.tracks.residual_m[6:8] = -error_m * late
        scene.tracks.residual_valid[:] = True
        scene.statistic[:, 0] = 0.5 + 0.01 * np.arange(12) + 0.1 * np.sin(step)
        scene.statistic[6:8, 0] += 3.0 * late
        scene.scored[8:10] = not 20 <= step < 60
        scene.alarm[:, 0] = False
        scene.alarm[6:8, 0] = late
        scene.estimate_m[:] = scene.vehicles.rear_m[:, None] + [0.1, 0.05]
        scene.estimate_m[6:, 1, 1] = error_m * late
        scene.isolated[6:8, 0] = late
        rows = list(range(12)) if step >= 20 else list(range(6))
        scene.observe(step, rows)
        steps.observe(scene.view(step, rows), [ids[row] for row in rows], scene.seen)
    for row in range(12):
        scene.close(row, ids[row])
    steps.close()
    if not log:
        steps.path.unlink()
    scene.outcomes.write(folder, scenario, 1, replicates=50, projector=NET)
    (folder / "map.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": _features()}))
    (folder / "manifest.json").write_text(json.dumps({"scenarios": [manifest(scenario)]}))
    return folder


def _features() -> list[dict]:
    line = NET.to_lon_lat(np.array(LANE_M)).tolist()
    ring = NET.to_lon_lat(np.array([[0.0, 0.0], [50.0, 0.0], [50.0, 20.0], [0.0, 0.0]])).tolist()
    lane = {"kind": "lane", "id": "e_0", "internal": False, "width_m": 3.5}
    return [
        {"type": "Feature", "properties": lane, "geometry": {"type": "LineString", "coordinates": line}},
        {
            "type": "Feature",
            "properties": {"kind": "zone", "id": EVIL, "attack": "drift"},
            "geometry": {"type": "Polygon", "coordinates": [ring]},
        },
    ]


def manifest(scenario: str) -> dict:
    plans = [
        {"name": name, "attack": "constant_bias", "share": 0.5, "parameters": {"bias_m": 2.4, "side": "random"}}
        for name in PLANS[1:]
    ]
    return {
        "scenario": scenario,
        "seed": 1,
        "gpsec_version": "0.1.0",
        "git_commit": None,
        "versions": {"libsumo": "1.28.0"},
        "configuration": {
            "sumocfg": "nowhere/lane.sumocfg",
            "engine": "batched",
            "fleet": {"equipped_share": 1.0, "association": "tracked", "settle_s": 10.0},
            "detection": {"rates": ["1e-3/sample"]},
            "localization": {"hold_s": 2.0, "rejoin_s": 1.0, "outage_s": 0.5},
            "outcomes": {"bootstrap": 50, "confidence": 0.95},
        },
        "step_s": 0.1,
        "profiles": ["dsd"],
        "plans": plans,
        "notes": [f"step lowered because of {EVIL}"],
        "steps": 80,
        "vehicles": 6,
        "vehicle_steps": 480,
        "peak_vehicles": 6,
        "sumo_s": 1.0,
        "stages_s": {"truth": 0.5},
    }


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("report") / "run")


@pytest.fixture
def run(run_folder: Path) -> Results:
    return load(run_folder)
