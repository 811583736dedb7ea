"""Who waits for somebody that gpsec holds still: passes where there is room, and stands for a reason where not."""

import pytest

from gpsec.traffic import waits
from gpsec.traffic.blockers import PATIENCE_S

from .driven import CAR, Driven

ROUTES = (
    '<route id="east" edges="A1B1 B1C1"/><route id="north" edges="B0B1 B1B2"/>'
    '<vehicle id="wreck" type="car" depart="0" departLane="0" departPos="160" departSpeed="10" route="east"/>'
    '<vehicle id="other" type="car" depart="5" departLane="0" departPos="120" departSpeed="10" route="north"/>'
    '<vehicle id="next" type="car" depart="8" departLane="0" departPos="120" departSpeed="10" route="north"/>'
)


def drive(config, lanes, brakes_from_m, lasts_s=200.0):
    """Return when those who cross were past the junction; the last frame, where all were in it, and who passed."""
    passed = {}
    with Driven(config, lanes) as driven:
        for frame in driven.frames(30.0):
            if "wreck" in driven.place:
                brakes = driven.place["wreck"][0] > brakes_from_m and frame.time_s < lasts_s
                driven.steer("wreck", 0.0, 9.0 if brakes else 0.0)
            for name, place in driven.place.items():
                if name != "wreck" and place[1] > 215.0:
                    passed.setdefault(name, frame.time_s)
        return passed, frame, dict(driven.place), driven.session._blockers._passed


def test_a_wreck_behind_its_stop_line_is_passed_after_a_while(scenario, lane_index):
    """In SUMO both would stand for ever: the wreck is on a lane that crosses theirs, but twelve metres before."""
    passed, frame, place, ignored = drive(scenario(CAR + ROUTES), lane_index, 187.0)
    assert place["wreck"][0] == pytest.approx(194.0, abs=3.0)
    assert 4.0 + PATIENCE_S < passed["other"] < passed["next"] < 30.0
    assert frame.carried.stuck == 0
    assert not ignored


def test_a_wreck_in_the_way_is_not_passed_and_is_a_reason(scenario, lane_index):
    passed, frame, place, _ = drive(scenario(CAR + ROUTES), lane_index, 196.0)
    assert 203.5 < place["wreck"][0] < 209.0
    assert not passed
    assert place["other"][1] < 200.0
    assert frame.carried.stuck == 0


def test_who_drives_on_is_given_way_to_again(scenario, lane_index):
    passed, frame, place, ignored = drive(scenario(CAR + ROUTES), lane_index, 187.0, lasts_s=15.0)
    assert "wreck" not in place or place["wreck"][0] > 215.0
    assert set(passed) == {"other", "next"}
    assert not ignored
    assert frame.carried.stuck == 0


def test_who_waits_in_the_middle_of_a_junction_for_a_stream_is_not_stuck(scenario, lane_index):
    """It turns left; those that come towards it for a minute leave no gap."""
    stream = "".join(
        f'<vehicle id="s{k}" type="car" depart="{0.8 * k}" departLane="{k % 2}" departSpeed="max" route="south"/>'
        for k in range(90)
    )
    routes = '<route id="south" edges="B2B1 B1B0"/><route id="turn" edges="B0B1 B1A1"/>'
    slow = '<vehicle id="v" type="slow" depart="0" departLane="1" departPos="100" route="turn"/>'
    config = scenario(CAR + routes + slow + stream)
    with Driven(config, lane_index) as driven:
        stood = stuck = 0
        for frame in driven.frames(90.0):
            stuck = frame.carried.stuck
            driven.steer("v")
            if "v" in driven.row:
                stood += driven.session._actuation.now.speed_mps[driven.row["v"]] < 0.1
        assert stood * driven.session.step_s > 35.0
        assert stuck == 0


@pytest.mark.parametrize(
    ("awaited", "with_reason", "stuck"),
    [
        ({"a": []}, "", "a"),
        ({"a": []}, "a", ""),
        ({"a": ["b"], "b": ["a"], "c": ["a"]}, "", "ab"),
        ({"a": ["b"], "b": ["a", "d"], "c": ["a"], "d": []}, "d", ""),
        ({"a": ["b"], "b": ["c"], "c": []}, "", "c"),
    ],
)
def test_stuck_is_who_waits_for_nobody_or_in_a_circle(monkeypatch, awaited, with_reason, stuck):
    monkeypatch.setattr(waits, "_awaited", awaited.__getitem__)
    monkeypatch.setattr(waits, "_has_reason", with_reason.__contains__)
    assert "".join(name for name in awaited if waits.is_stuck(name, "".__contains__)) == stuck
