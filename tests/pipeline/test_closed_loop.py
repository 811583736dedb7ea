"""Vehicles that steer by their estimates, from the scenario to the tables: who leaves the lane, and who does not."""

import json

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.pipeline.closed_loop import ClosedLoop
from gpsec.pipeline.run import run_scenario
from gpsec.pipeline.warmup_run import Extras
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.scenario.worlds import with_worlds

SETS = (
    "duration_s=30.0",
    "fleet.settle_s=1.0",
    "fleet.profile=carla",
    "detection.detectors=[]",
    'defences=[{detector="told",response="ukf"}]',
    'plans=[{attack="constant_bias",share=0.5,bias_m=1.5,start_after_s=[1.0,2.0],duration_s=[15.0,15.0]}]',
)


def worlds(repository, *sets, net="slow_curve"):
    changes = [parse_set(text) for text in (*SETS, *sets)]
    return with_worlds(load_scenario(repository / "scenarios" / net, changes), [5])


def go(world, folder):
    folder.mkdir()
    run_scenario(world, folder, lambda progress: None)
    return folder


@pytest.fixture(scope="module")
def ran(repository, tmp_path_factory):
    """The folders of a benign, an undefended and a defended world."""
    made = tmp_path_factory.mktemp("worlds")
    return [go(world, made / world.name) for world in worlds(repository)]


def row(folder):
    return pd.read_csv(folder / "worlds.csv").iloc[0]


def test_undefended_vehicles_truly_leave_their_lanes_and_defended_ones_do_not(ran):
    benign, undefended, defended = (row(folder) for folder in ran)
    assert benign["attacked"] == benign["out_of_lane"] == benign["collisions"] == 0
    assert undefended["attacked"] == defended["attacked"] > 8
    assert defended["alarms"] == defended["attacked"]
    assert defended["stops"] == defended["handovers"] == defended["mrm"] == 0
    stories = pd.read_csv(ran[1] / "events.csv")
    stories = stories[(stories["defence"] == "never+none") & (stories["attack_seconds"] > 8.0)]
    assert len(stories) > 4
    assert stories["displaced_max_m"].between(1.2, 2.2).all()
    kept = pd.read_csv(ran[2] / "events.csv")
    assert kept["displaced_max_m"].max() < 0.9
    assert kept["displaced_max_m"].max() > 0.05


def test_who_is_attacked_and_when_is_the_same_in_all_worlds_and_in_open_loop(ran, repository, tmp_path):
    world = worlds(repository)[1]
    section = world.closed_loop.model_copy(update={"world": None})
    go(world.model_copy(update={"closed_loop": section}), tmp_path / "open")
    columns = ["vehicle_id", "start_s"]
    tables = [pd.read_csv(folder / "events.csv")[columns] for folder in (ran[1], ran[2], tmp_path / "open")]
    first = [table.drop_duplicates().sort_values("start_s").head(5).reset_index(drop=True) for table in tables]
    pd.testing.assert_frame_equal(first[0], first[1])
    pd.testing.assert_frame_equal(first[0], first[2])


def test_the_same_seed_gives_the_same_bytes_for_any_threads(ran, repository, tmp_path):
    world = worlds(repository, "threads=2")[1]
    again = go(world, tmp_path / "again")
    for table in ("worlds", "collisions", "events", "detection", "vehicles", "localization"):
        assert (again / f"{table}.csv").read_bytes() == (ran[1] / f"{table}.csv").read_bytes()


def test_the_manifest_says_which_options_were_set_and_who_was_steered(ran):
    manifest = json.loads((ran[1] / "manifest.json").read_text())
    assert sum("closed loop:" in note for note in manifest["notes"]) >= 4
    assert manifest["closed_loop"]["steered_vehicle_steps"] > 500
    assert manifest["closed_loop"]["teleports"] == 0
    assert manifest["plans"][0]["name"] == "constant_bias"


def test_a_stop_on_an_alarm_stops_the_vehicle(repository, tmp_path):
    sets = ("closed_loop.on_alarm=stop", 'closed_loop.worlds=[{plan="constant_bias",defence="told+ukf"}]')
    world = worlds(repository, *sets)[1]
    folder = go(world, tmp_path / "stop")
    found = row(folder)
    assert found["stops"] == found["attacked"] > 8
    stories = pd.read_csv(folder / "events.csv")
    assert (stories["stood_s"] > 1.0).sum() > 4
    jam, stood = pd.read_csv(folder / "jams.csv"), pd.read_csv(folder / "standing.csv")
    halted = jam[jam["stopped"] & (jam["speed_mps"] == 0.0)]
    assert len(halted) > 10
    assert jam["position_m"].between(0.0, jam["length_m"]).all()
    assert set(jam["road"]) <= set(stood["road"])
    at_rest = halted.groupby("vehicle")["position_m"]
    assert (at_rest.max() - at_rest.min()).max() < 0.1


def test_false_alarms_come_at_the_rate_that_is_asked_for(repository, tmp_path):
    """Of 600 an hour, one in 6 s, exp(-5/6) find the vehicle driving, which stops for 5 s after each."""
    asked = '[{on_alarm="stop",false_alarms_per_h=600.0}]'
    world = worlds(repository, f"closed_loop.worlds={asked}")[1]
    folder = go(world, tmp_path / "false")
    found, vehicles = row(folder), pd.read_csv(folder / "vehicles.csv")
    hours = vehicles[vehicles["defence"] == "never+none"]["vehicle_seconds"].sum() / 3600.0
    assert found["alarms"] > 10
    assert abs(found["alarms"] - 600.0 * hours) < 4.0 * (600.0 * hours) ** 0.5
    assert found["attacked"] == 0
    assert abs(found["stops"] / found["alarms"] - np.exp(-5.0 / 6.0)) < 0.15


@pytest.mark.slow
def test_who_departed_has_arrived_was_taken_away_or_is_on_the_road(repository, tmp_path, monkeypatch):
    """Wrecks are taken away a second after the crash; at the end some vehicles are still on the road."""
    on_road, step = [], ClosedLoop.step

    def watched(self, frame, *more):
        on_road.append(len(frame.rows))
        return step(self, frame, *more)

    monkeypatch.setattr(ClosedLoop, "step", watched)
    plan = 'plans=[{attack="stealth",share=0.5}]'
    world = worlds(repository, plan, "closed_loop.wreck_s=1.0", "duration_s=120.0", net="town")[1]
    found = row(go(world, tmp_path / "wrecks"))
    assert found["removed"] > 0
    assert found["arrived"] > 0
    assert on_road[-1] > 0
    assert found["vehicles"] == found["arrived"] + found["removed"] + on_road[-1]


def test_what_is_recorded_cannot_react(repository, tmp_path):
    world = worlds(repository)[1]
    with pytest.raises(GpsecError, match="expected SUMO, found a recording"):
        run_scenario(world, tmp_path, lambda progress: None, Extras)
