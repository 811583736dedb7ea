"""The verdict on a run, from tables that are written here by hand."""

import numpy as np
import pandas as pd
import pytest

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.ranking import candidates, in_time, rankings

DEFENCES = ("never+none", "told+ukf", "a+ukf", "b+ukf", "a@1e-3/sample+ukf")


def event(vehicle, attack, defence, **others):
    plain = {
        "scenario": "town",
        "vehicle_id": f"v{vehicle}",
        "profile": "carla",
        "attack": attack,
        "defence": defence,
        "outcome": "none",
        "time_to_line_s": np.nan,
        "detection_delay_s": np.nan,
        "rmse_cross_track_m": 1.0,
        "rmse_along_track_m": 0.1,
        "true_positives": 10,
        "false_negatives": 0,
    }
    return plain | others


def tables(events, note=""):
    frame = pd.DataFrame(events)
    groups = frame[["scenario", "profile"]].drop_duplicates().to_dict("records")
    safety = [
        group | {"attack": "none", "defence": name, "note": note, "isolated_minutes_per_vehicle_hour": 0.5}
        for group in groups
        for name in DEFENCES
    ]
    detectors = list(dict.fromkeys(name.partition("+")[0] for name in DEFENCES))
    rate = {"vehicle_hours": 2.0, "false_alarms_per_vehicle_hour": 0.25}
    detection = [group | rate | {"detector": name} for group in groups for name in detectors]
    return {"events": frame, "safety": pd.DataFrame(safety), "detection": pd.DataFrame(detection)}


def fleet(vehicles, out_of, attacks=("bias",), **others):
    """Return events of so many vehicles, of which the first `out_of[defence]` leave their lane under all attacks."""
    return [
        event(v, attack, name, outcome="off_road" if v < out_of.get(name, 0) else "none", **others)
        for v in range(vehicles)
        for attack in attacks
        for name in DEFENCES
    ]


def ranked(events, **others):
    return rankings(tables(events, **others), Bootstrap(1, 1000, 0.95))


def test_one_that_is_better_than_all_others_is_the_winner():
    (found,) = ranked(fleet(60, {"never+none": 50, "b+ukf": 20}))
    assert found.winner == "a+ukf"
    assert found.vehicles == 60
    assert found.undefended.share == pytest.approx(50 / 60)
    assert found.standings["a+ukf"].false_alarms_per_h == 0.25
    assert found.standings["a+ukf"].without_gnss_min_per_h == 0.5
    assert found.vehicle_hours == 2.0
    # None of 60 left its lane: Wilson's bound of none, z² / (n + z²).
    assert found.standings["a+ukf"].high == pytest.approx(1.95996**2 / (60 + 1.95996**2), rel=1e-4)


def test_those_that_cannot_be_told_apart_are_named_together():
    (found,) = ranked(fleet(60, {"never+none": 50, "b+ukf": 3}))
    assert found.best == ("a+ukf", "b+ukf")
    assert found.winner is None
    assert found.helps


def test_no_defence_helps_where_none_is_better_than_nothing():
    (found,) = ranked(fleet(60, {"never+none": 2, "b+ukf": 2}))
    assert not found.helps
    assert found.winner is None
    assert "never+none" in found.best


def test_plans_do_not_multiply_vehicles():
    """Five vehicles that differ are too few, also where eight plans attack each of them."""
    (found,) = ranked(fleet(60, {"never+none": 50, "b+ukf": 5}, attacks=[f"plan{i}" for i in range(8)]))
    assert found.vehicles == 60
    assert found.best == ("a+ukf", "b+ukf")


def test_what_acts_along_the_road_and_what_leaves_nothing_to_compare_stand_apart():
    events = fleet(60, {"never+none": 50, "b+ukf": 20})
    events += fleet(60, dict.fromkeys(DEFENCES, 60), ("replay",), rmse_along_track_m=30.0)
    events += fleet(60, dict.fromkeys(DEFENCES, 60), ("jamming",), true_positives=0)
    (found,) = ranked(events)
    assert found.apart == {"replay": "along the road", "jamming": "nothing to compare"}
    assert found.attacks == ("bias",)
    assert found.winner == "a+ukf"


def test_where_outcomes_are_those_of_the_receiver_nothing_is_judged():
    (found,) = ranked(fleet(60, {"never+none": 50}), note="94% touch a line")
    assert (found.best, found.note, found.undefended) == ((), "94% touch a line", None)


def test_vehicles_of_all_seeds_are_taken_together():
    events = [
        one | {"scenario": f"town-seed-{seed}"}
        for seed in (1, 2, 3)
        for one in fleet(30, {"never+none": 20, "b+ukf": 10})
    ]
    given = tables(events)
    for name in ("safety", "detection"):
        given[name] = given[name][given[name]["scenario"] == "town-seed-1"].assign(scenario="town")
    (found,) = rankings(given, Bootstrap(1, 1000, 0.95))
    assert found.vehicles == 90
    assert found.undefended.share == pytest.approx(2 / 3)


def test_candidates_are_at_the_headline_rate_and_not_told():
    assert candidates(list(DEFENCES)) == ["never+none", "a+ukf", "b+ukf"]
    assert candidates(["never+none", "told+ukf", "a@1/h+ukf"]) == ["never+none", "a@1/h+ukf"]


def test_an_alarm_is_in_time_if_it_comes_before_the_line():
    events = [event(v, "bias", "never+none", time_to_line_s=2.0) for v in range(4)]
    events += [event(v, "bias", "a+ukf", detection_delay_s=s) for v, s in enumerate([0.5, 1.0, 2.0, np.nan])]
    assert in_time(pd.DataFrame(events), "a+ukf") == (4, 0.5, 1.25)
