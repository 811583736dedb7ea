"""The worlds of a scenario, and what is refused in one sentence."""

import pytest

from gpsec.core.errors import GpsecError
from gpsec.scenario import load_scenario
from gpsec.scenario.closed_loop import ClosedWorld
from gpsec.scenario.model import Scenario
from gpsec.scenario.overrides import parse_set
from gpsec.scenario.worlds import can_steer, shown_world, with_false_alarms, with_worlds, worlds_of
from gpsec.sensors.registry import PROFILES


@pytest.fixture
def scenario(repository):
    def load(*sets, name="town"):
        return load_scenario(repository / "scenarios" / name, [parse_set(text) for text in sets])

    return load


def test_by_default_the_first_plan_meets_no_defence_and_the_last(scenario):
    last = "joint+ukf5_rollback"
    assert worlds_of(scenario()) == [
        ClosedWorld(plan="none", defence="never+none", on_alarm="continue"),
        ClosedWorld(plan="constant_bias", defence="never+none", on_alarm="continue"),
        ClosedWorld(plan="constant_bias", defence=last, on_alarm="continue"),
    ]


def test_each_defence_and_reaction_has_a_benign_twin_where_they_differ_without_an_attack(scenario):
    asked = '[{plan="drift"},{plan="stealth",defence="lstm_glr+ukf"},{plan="drift",on_alarm="continue"}]'
    found = worlds_of(scenario(f"closed_loop.worlds={asked}", "closed_loop.on_alarm=stop"))
    assert [(one.plan, one.defence, one.on_alarm) for one in found] == [
        ("none", "never+none", "stop"),
        ("none", "lstm_glr+ukf", "stop"),
        ("none", "never+none", "continue"),
        ("drift", "never+none", "stop"),
        ("stealth", "lstm_glr+ukf", "stop"),
        ("drift", "never+none", "continue"),
    ]
    everybody = scenario('closed_loop.worlds=[{plan="drift",defence="lstm_glr+ukf"}]', "closed_loop.steer=all")
    assert worlds_of(everybody)[0] == ClosedWorld(plan="none", defence="lstm_glr+ukf", on_alarm="continue")


def test_a_world_is_a_scenario_of_its_own_and_survives_the_way_to_another_process(scenario):
    worlds = with_worlds(scenario(), [3, 4])
    assert [one.name for one in worlds[:3]] == ["town-world-00-seed-3", "town-world-00-seed-4", "town-world-01-seed-3"]
    assert [[plan.name for plan in one.plans] for one in worlds[1:3]] == [[], ["constant_bias"]]
    assert worlds[2].seed == 3
    again = Scenario.model_validate_json(worlds[2].model_dump_json())
    assert again.closed_loop == worlds[2].closed_loop
    assert again.closed_loop.world.plan == "constant_bias"


def test_profiles_that_keep_a_lane_can_steer():
    assert {name for name in PROFILES if not can_steer(name)} == {"consumer", "urban"}


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (['closed_loop.worlds=[{plan="sealth"}]'], r"worlds\.0\.plan: unknown plan 'sealth': did you mean 'stealth'"),
        (['closed_loop.worlds=[{defence="lstm+ukf"}]'], r"worlds\.0\.defence: unknown defence 'lstm\+ukf'"),
        (["plans=[]"], "expected a plan to attack by, found no plans"),
        (["fleet.profile=consumer"], r"expected one whose fixes are within 0\.5 m .* found consumer"),
        (["engine=reference"], "expected engine 'batched', found 'reference'"),
    ],
)
def test_worlds_that_cannot_be_are_refused(scenario, sets, said):
    with pytest.raises(GpsecError, match=said) as caught:
        worlds_of(scenario(*sets))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("closed_loop.on_alarm=halt", "unknown reaction 'halt'"),
        ("closed_loop.dynamics=third_order", "unknown lateral dynamics 'third_order'"),
        ("closed_loop.reaction_parameters={decel=1.0}", "unknown key 'decel' of 'continue'"),
        ("closed_loop.dynamics_parameters={bandwidth_rps=99.0}", "bandwidth_rps: expected less than or equal to 10"),
        ("closed_loop.steer=some", "closed_loop.steer"),
        ('closed_loop.worlds=[{plan="drift",on_alarm="halt"}]', "unknown reaction 'halt'"),
    ],
)
def test_keys_that_mean_nothing_are_refused(scenario, text, said):
    with pytest.raises(GpsecError, match=said):
        scenario(text)


def test_false_alarms_have_worlds_of_their_own_and_one_without(scenario):
    found = worlds_of(with_false_alarms(scenario(), [5.0, 0.0]))
    assert [(one.plan, one.on_alarm, one.false_alarms_per_h) for one in found] == [
        ("none", "stop", 0.0),
        ("none", "stop", 5.0),
    ]
    with pytest.raises(GpsecError, match="expected 0 to 3600 a vehicle-hour, found -1"):
        with_false_alarms(scenario(), [-1.0])


def test_the_world_that_is_shown_is_the_first_with_an_attack_or_the_one_that_is_asked_for(scenario):
    worlds = '[{plan="drift"},{plan="stealth"},{plan="stealth",defence="lstm_glr+ukf"}]'
    found = scenario(f"closed_loop.worlds={worlds}", "seed=9")

    def world(plan=None, defence=None):
        one = shown_world(found, plan, defence)
        assert (one.seed, [plan.name for plan in one.plans]) == (9, [one.closed_loop.world.plan])
        return one.closed_loop.world.plan, one.closed_loop.world.defence

    assert world() == ("drift", "never+none")
    assert world("stealth") == ("stealth", "never+none")
    assert world(defence="lstm_glr+ukf") == ("stealth", "lstm_glr+ukf")
    with pytest.raises(GpsecError, match=r"--gui-plan: no world .* plan 'sealth': did you mean 'stealth'"):
        world("sealth")
    with pytest.raises(GpsecError, match=r"--gui-defence: no world in closed loop has defence 'lstm_glr\+ukf'"):
        world("drift", "lstm_glr+ukf")
    with pytest.raises(GpsecError, match="expected a world with an attack to show, found none"):
        shown_world(with_false_alarms(found, [5.0]), None, None)


def test_more_worlds_than_a_machine_can_hold_are_refused(scenario):
    with pytest.raises(GpsecError, match="expected at most 2000 worlds in all, found 3 × 700 seeds"):
        with_worlds(scenario(), range(700))
