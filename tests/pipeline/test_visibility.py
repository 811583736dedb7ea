"""`fleet.camera.visibility = "place"` in a run: lanes are lost where the net says, and not by the clock."""

import json
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from gpsec.pipeline.build import lay_ground
from gpsec.scenario import Scenario
from gpsec.scenario.load import changed
from gpsec.scenario.overrides import parse_set

from .conftest import Traffic

SETS = ('fleet.camera.visibility="place"', "log_steps=true", "detection.detectors=[]", "defences=[]", "plans=[]")


def test_cameras_lose_the_lane_by_place(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Callable[[Scenario], Path]
) -> None:
    replay(traffic)
    scenario = changed(town, [parse_set(text) for text in SETS])
    folder = go(scenario)
    notes = json.loads((folder / "manifest.json").read_text())["notes"]
    assert any(note.startswith("cameras lose the lane by place: lines are those of town.paint.csv") for note in notes)
    steps = pd.read_parquet(folder / "steps.parquet")
    ground = lay_ground(scenario)
    lanes, hd_map = steps["lane"], ground.hd_map
    road = steps[~lanes.str.startswith(":")]
    left_m = []
    for lane, x, y in zip(road["lane"], road["x_m"], road["y_m"], strict=True):
        end = hd_map.centre_line(hd_map.lane_index[lane])[-1]
        left_m.append(float(((end[0] - x) ** 2 + (end[1] - y) ** 2) ** 0.5))
    road = road.assign(left_m=left_m)
    near, far = road[road["left_m"] < 10.0], road[road["left_m"] > 60.0]
    # The rear axle may still be on the lane before; nearly all that are near a stop line see nothing.
    assert near["camera_offset_m"].notna().mean() < 0.1
    assert far["camera_offset_m"].notna().mean() > 0.7
