"""Who waits for somebody that gpsec holds still: passes where there is room, and stands for a reason where not."""

import pytest

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
