"""The set-up of FusionRipper: its distances follow from the widths of roads and car; d and f are those that succeed."""

import pandas as pd
import pytest

from benchmarks import fusion_ripper
from benchmarks.fusion_ripper import ROADS, best, build, plan_name, plans, successes
from gpsec.hdmap.map import load_map
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

LOCAL, HIGHWAY = ROADS


def test_the_distances_are_those_of_the_paper():
    assert LOCAL.goals == pytest.approx({"off road": 0.895, "wrong way": 2.405})
    assert HIGHWAY.goals == pytest.approx({"off road": 1.945, "wrong way": 2.855})
    assert (LOCAL.line_m, HIGHWAY.line_m) == pytest.approx((0.295, 0.745))


def test_the_best_reach_the_next_lane_most_often_and_the_smallest_wins_a_tie():
    def attacks(d_m, f, off, wrong):
        row = {"attack": plan_name(d_m, f), "defence": "a+b"}
        return [{**row, "off road": at < off, "wrong way": at < wrong} for at in range(4)]

    found = [attacks(d_m, f, 4, 1) for d_m in fusion_ripper.D_M for f in fusion_ripper.F]
    found += [attacks(0.6, 1.6, 4, 4), attacks(2.0, 1.1, 4, 4), attacks(0.3, 1.1, 4, 1)]
    assert best(pd.DataFrame([row for rows in found for row in rows]), "a+b") == (0.6, 1.6)


def test_attacks_that_begin_too_late_are_not_counted(tmp_path):
    events = pd.DataFrame({"start_s": [10.0, 119.0, 121.0], "max_cross_track_m": [1.0, 2.5, 9.0]})
    events.to_csv(tmp_path / "events.csv", index=False)
    found = successes(tmp_path, LOCAL, 180.0, "max_cross_track_m")
    assert found[["off road", "wrong way"]].to_numpy().tolist() == [[True, False], [True, True]]


def test_the_roads_have_their_widths_and_the_scenario_can_be_read(tmp_path, monkeypatch):
    monkeypatch.setattr(fusion_ripper, "BUILT", tmp_path)
    for road in ROADS:
        config = build(road)
        lanes = load_map(config.parent / "road.net.xml", (1.0,))
        assert len(lanes.lane_ids) == 2 * road.lanes
        assert lanes.sides.width_m == pytest.approx(road.lane_m)
        # Each direction has the other one beside it.
        assert lanes.sides.oncoming_left_m == pytest.approx(road.lanes * road.lane_m)
        sets = [f"sumocfg={config}", plans(road, [(0.3, 1.1), (2.0, 1.6)])]
        scenario = load_scenario(fusion_ripper.SCENARIO, [parse_set(text) for text in sets])
        assert [plan.name for plan in scenario.plans] == ["d0.3_f1.1", "d2_f1.6"]
        assert {defence.name for defence in scenario.defences} >= set(fusion_ripper.DEFENCES)
