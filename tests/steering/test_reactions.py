"""What vehicles do on an alarm, with times by hand."""

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.steering.base import Follow, Situation
from gpsec.steering.registry import REACTIONS, build_part


def conduct(name, alarms, count=1, step_s=0.1, **parameters):
    """Follow and braking, (steps, count), of vehicles that are all in alarm in the given steps."""
    reaction = REACTIONS[name](**parameters)
    state = reaction.new_state(count).now
    rows, key = np.arange(count, dtype=np.int32), np.arange(1, count + 1).astype(np.uint64)
    answers = [
        reaction.apply(Situation(rows, key, k, step_s, np.full(count, alarm), np.full(count, 9.0)), state)
        for k, alarm in enumerate(alarms)
    ]
    return np.array([one.follow for one in answers]), np.array([one.brake_mps2 for one in answers])


@pytest.mark.parametrize(("name", "follows"), [("stop", Follow.LANE), ("pull_over", Follow.EDGE)])
def test_a_vehicle_stops_until_the_alarm_has_been_over_for_a_while(name, follows):
    follow, brake = conduct(name, [False] * 2 + [True] * 3 + [False] * 15, decel_mps2=3.0, hold_s=1.0)
    stops = [False] * 2 + [True] * 13 + [False] * 5
    assert (follow[:, 0] == follows).tolist() == stops
    assert brake[:, 0].tolist() == [3.0 * stop for stop in stops]


def test_a_driver_takes_over_in_a_lognormal_time():
    follow, brake = conduct("handover", [True] * 1500, count=4000, step_s=0.01, mrm_after_s=600.0)
    assert not brake.any()
    takes_s = np.argmax(follow == Follow.LANE, axis=0) * 0.01
    taken = (follow == Follow.LANE).any(axis=0)
    assert taken.mean() > 0.999
    assert takes_s[taken].mean() == pytest.approx(2.7, abs=0.08)
    assert takes_s[taken].std() == pytest.approx(1.45, abs=0.15)
    assert np.log(takes_s[taken]).std() == pytest.approx(np.sqrt(np.log(1.0 + (1.45 / 2.7) ** 2)), abs=0.02)


def test_without_an_answer_the_vehicle_stops_in_its_lane_until_the_driver_is_there():
    follow, brake = conduct("handover", [True] * 60, takeover_mean_s=4.0, takeover_sd_s=0.01, mrm_after_s=2.0)
    phases = [(Follow.ESTIMATE, 0.0)] * 20 + [(Follow.LANE, 1.5)] * 20 + [(Follow.LANE, 0.0)] * 20
    found = list(zip(follow[:, 0].tolist(), brake[:, 0].tolist(), strict=True))
    assert [k for k in range(60) if found[k] != phases[k] and k not in (39, 40, 41)] == []


def test_nobody_is_asked_without_an_alarm_and_each_alarm_asks_anew():
    follow, _ = conduct("handover", [False] * 9, hold_s=0.0)
    assert not follow.any()
    alarms = ([True] * 80 + [False] * 2) * 2
    follow, _ = conduct("handover", alarms, hold_s=0.0, takeover_sd_s=1.0)
    first, second = np.argmax(follow[:82, 0] == Follow.LANE), np.argmax(follow[82:, 0] == Follow.LANE)
    assert 0 < first != second > 0


def test_parameters_are_refused_in_one_sentence():
    with pytest.raises(GpsecError, match=r"unknown key 'decel_mps' of 'stop'.*did you mean 'decel_mps2'"):
        build_part(REACTIONS, "stop", {"decel_mps": 1.0})
    with pytest.raises(GpsecError, match="decel_mps2: expected less than or equal to 9, found 99"):
        build_part(REACTIONS, "stop", {"decel_mps2": 99.0})
    with pytest.raises(GpsecError, match="unknown reaction 'halt'"):
        build_part(REACTIONS, "halt", {})
