"""What displacements mean, what attacks do to traffic, and the tables of the closed loop; figures by hand."""

import numpy as np
import pandas as pd
import pytest

from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.displaced import reached
from gpsec.outcomes.effects import MEASURES, effects_table
from gpsec.outcomes.tables import write_frame
from gpsec.outcomes.true_outcomes import TrueOutcomes, TrueStep, WorldTotals
from gpsec.outcomes.worlds import (
    COLLISION_COLUMNS,
    KEPT_COLUMNS,
    STORY_COLUMNS,
    WorldEnd,
    WorldKey,
    write_kept,
    write_world,
)

from .test_dictionary import README, documented

# A lane of 3.2 m with a like one to the right and an oncoming one of 3 m to the left; the second is in a junction.
SIDES = LaneSides(
    width_m=np.array([3.2, 3.2]),
    internal=np.array([False, True]),
    same_left_m=np.zeros(2),
    same_right_m=np.array([3.2, 3.2]),
    oncoming_left_m=np.array([3.0, 3.0]),
    oncoming_right_m=np.zeros(2),
)


@pytest.mark.parametrize(
    ("displaced_m", "count"),
    [
        *[(0.69, 0), (0.71, 1), (1.59, 1), (1.61, 2), (2.49, 2), (2.51, 3), (5.49, 3), (5.51, 4)],
        *[(-0.71, 1), (-1.61, 2), (-5.69, 2)],
    ],
)
def test_limits_to_the_left_are_line_lane_oncoming_and_road(displaced_m, count):
    """A car of 1.8 m touches the line from 0.7 m, is beyond it from 2.5 m, and beyond the oncoming lane from 5.5 m."""
    found = reached(np.array([displaced_m]), np.array([1.8]), np.zeros(1, np.int32), SIDES)
    assert found[0].tolist() == [k < count for k in range(4)]


def test_to_the_right_there_is_no_oncoming_lane_and_in_junctions_there_are_no_limits():
    lanes = np.array([0, 1], np.int32)
    found = reached(np.array([-5.71, -5.71]), np.full(2, 1.8), lanes, SIDES)
    assert found.tolist() == [[True, True, False, True], [False] * 4]


def step(speed, offset=0.0, attacked=True, alarm=False, out=(False,) * 4, released=()):
    flag = np.array([alarm])
    return TrueStep(
        rows=np.array([2], np.int32),
        attacked=np.array([attacked]),
        alarm=flag,
        speed_mps=np.array([speed]),
        offset_m=np.array([offset]),
        reached=np.array([out]),
        stopping=flag,
        driver=np.array([False]),
        released=np.array(released, np.int32),
    )


def test_the_story_of_a_vehicle():
    """Attacked from step 3: over the line at 4, out of the lane at 5, hit at 6, standing from 7, released at 9."""
    happened = TrueOutcomes(0.1, 0.0)
    happened.enter(np.array([2], np.int32))
    line, out = (True, False, False, False), (True, True, False, False)
    steps = [
        *[step(10.0, attacked=False)] * 3,
        step(10.0),
        step(10.0, 0.9, out=line),
        step(10.0, -1.9, out=out, alarm=True),
        step(9.0, 1.0, out=line, alarm=True),
        step(0.0, 0.5),
        step(0.0, 0.2, attacked=False),
        step(0.0, attacked=False, released=[2]),
    ]
    for number, one in enumerate(steps):
        happened.add(number, one)
        if number == 6:
            happened.crash(number, 2, 1)
    happened.close({2: "v"}, {1: "crossing"})
    (story,) = happened.stories
    assert story["true_outcome"] == "out_of_lane"
    assert story["displaced_max_m"] == 1.9
    assert [story[name] for name in ("true_outcome_s", "crash_s", "stood_s", "released_s")] == pytest.approx(
        [0.2, 0.3, 0.3, 0.6]
    )
    assert story["crash_kind"] == "crossing"
    totals = happened.totals
    assert (totals.vehicles, totals.attacked, totals.alarms, totals.stops, totals.hard_brakings) == (1, 1, 1, 1, 1)
    assert totals.vehicle_km == pytest.approx(0.0069)
    assert totals.standing_steps == 3
    assert totals.reached.tolist() == [1, 1, 0, 0]


def test_who_was_not_attacked_has_no_story():
    happened = TrueOutcomes(0.1, 0.0)
    happened.enter(np.array([2], np.int32))
    happened.add(0, step(10.0, attacked=False))
    happened.close({2: "v"}, {})
    assert happened.stories == []


def world(name, plan, seed, collisions, defence="never+none", on_alarm="continue", **figures):
    base = {"vehicle_km": 50.0, "delay_s": 4.0, "standing_share": 0.1, "mean_speed_mps": 10.0, "arrived": 9}
    key = {"scenario": f"{name}-seed-{seed}", "seed": seed, "plan": plan, "defence": defence, "on_alarm": on_alarm}
    key |= {"false_alarms_per_h": 0.0}
    return key | {"collisions": collisions} | base | figures


def test_effects_are_differences_of_pairs_of_one_seed():
    """3 and 1 collisions in 50 km are 60 and 20 per 1,000 km; less twins with 0 and 20, the effects are 60 and 0."""
    worlds = pd.DataFrame(
        [
            world("town-world-00", "none", 1, 0),
            world("town-world-00", "none", 2, 1),
            world("town-world-01", "stealth", 2, 1, delay_s=5.0),
            world("town-world-01", "stealth", 1, 3, delay_s=7.0),
            world("town-world-02", "stealth", 1, 0, defence="lstm+ukf"),
            world("town-world-02", "stealth", 2, 0, defence="lstm+ukf"),
        ]
    )
    found = effects_table(worlds)
    assert found["scenario"].tolist() == ["town", "town"]
    first, second = found.to_dict("records")
    assert (first["seeds"], first["collisions_per_1000_vkm"], first["delay_s"]) == (2, 30.0, 2.0)
    assert (first["twin_collisions_per_1000_vkm"], first["twin_delay_s"]) == (10.0, 4.0)
    assert (first["delay_s_low"], first["delay_s_high"]) == (1.0, 3.0)
    assert second["collisions_per_1000_vkm"] == -10.0  # by the only benign world there is


def test_a_world_that_has_a_benign_twin_of_its_own_is_compared_with_that():
    worlds = pd.DataFrame(
        [
            world("a-world-00", "none", 1, 0, on_alarm="stop", delay_s=1.0),
            world("a-world-01", "none", 1, 0, on_alarm="stop", delay_s=3.0, defence="lstm+ukf"),
            world("a-world-02", "drift", 1, 0, on_alarm="stop", delay_s=10.0, defence="lstm+ukf"),
        ]
    )
    (row,) = effects_table(worlds).to_dict("records")
    assert row["delay_s"] == 7.0
    assert np.isnan(row["delay_s_low"])


def test_false_alarms_are_compared_with_the_world_that_has_none():
    quiet, loud = (world(f"a-world-0{k}", "none", 1, 0, on_alarm="stop", delay_s=1.0 + k) for k in (0, 1))
    (row,) = effects_table(pd.DataFrame([quiet, loud | {"false_alarms_per_h": 5.0}])).to_dict("records")
    assert (row["plan"], row["false_alarms_per_h"], row["delay_s"]) == ("none", 5.0, 1.0)


def test_the_tables_have_the_columns_that_are_described(tmp_path):
    events = pd.DataFrame(
        {"vehicle_id": ["v", "v", "w"], "defence": ["a+b", "c+d", "a+b"], "outcome": ["none", "off_road", "none"]}
    )
    write_frame(events, tmp_path / "events.csv")
    hit = dict.fromkeys(COLLISION_COLUMNS, 1) | {"kind": "oncoming", "attacked": True, "other_attacked": False}
    story = dict.fromkeys(set(STORY_COLUMNS) - {"open_loop_outcome"}, 1.5) | {"vehicle_id": "v"}
    hits = [hit | {"slow": False}, hit | {"slow": False, "kind": "wreck"}, hit | {"slow": True}]
    end = WorldEnd(WorldTotals(), hits, [story], 1.0, 2, 3, 4, 5, 6, 0.5)
    write_world(tmp_path, WorldKey("town-world-01-seed-1", 1, "drift", "c+d", "stop"), end, 0.1)
    worlds = pd.read_csv(tmp_path / "worlds.csv")
    assert set(worlds.columns) == set(documented("worlds.csv"))
    counted = ["collisions", "collisions_oncoming", "collisions_with_others", "collisions_with_wrecks", "slow_touches"]
    assert worlds[counted].to_numpy().tolist() == [[1, 1, 1, 1, 1]]
    collisions = pd.read_csv(tmp_path / "collisions.csv")
    assert list(collisions.columns) == documented("collisions.csv")
    assert len(collisions) == 2
    write_kept(tmp_path, WorldKey("a", 1, "drift", "c+d", "stop"), {name: [] for name in KEPT_COLUMNS})
    for name in KEPT_COLUMNS:
        assert list(pd.read_csv(tmp_path / f"{name}.csv").columns) == documented(f"{name}.csv")
    told = pd.read_csv(tmp_path / "events.csv")
    assert told["open_loop_outcome"].tolist()[:2] == ["off_road", "off_road"]
    assert told["displaced_max_m"].isna().tolist() == [False, False, True]
    text = README.read_text("utf-8")
    assert all(f"`{name}`" in text for name in STORY_COLUMNS)
    assert set(effects_table(worlds).columns) == set(documented("effects.csv"))
    assert len(MEASURES) == 5
