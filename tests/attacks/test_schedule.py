"""Who is attacked, when, and never twice."""

import numpy as np
import pytest

from gpsec.attacks.plans import plan_config
from gpsec.attacks.schedule import (
    ATTACKED,
    NEVER,
    SPARED,
    UNDER_ATTACK,
    WAITING,
    Clock,
    Plan,
    Schedule,
    build_plans,
    needed_memory_s,
)
from gpsec.attacks.zones import Zone
from gpsec.core.errors import GpsecError
from gpsec.core.noise import vehicle_key
from gpsec.core.tables import Table

N = 4000
ROWS = np.arange(N, dtype=np.int32)
KEYS = np.array([vehicle_key(3, f"car{i}") for i in range(N)], np.uint64)
ALL = np.ones(N, np.bool_)
SECONDS = Clock(step_s=1.0)


def make_plan(attack: str = "drift", zone: Zone | None = None, **settings: object) -> Plan:
    table = {"attack": attack, "share": 1.0, **settings} | ({"zone": zone.zone_id} if zone else {})
    config = plan_config(table, "test")
    return Plan(config, zone)


def entered(plan: Plan, settled_step: int = 0, clock: Clock = SECONDS, type_ok: np.ndarray = ALL) -> Schedule:
    schedule = Table(Schedule, N).now
    plan.enter(schedule, ROWS, KEYS, type_ok, settled_step, clock)
    return schedule


def one(plan: Plan, settled_step: int = 0, clock: Clock = SECONDS) -> Schedule:
    schedule = Table(Schedule, 1).now
    plan.enter(schedule, ROWS[:1], KEYS[:1], ALL[:1], settled_step, clock)
    return schedule


def follow(plan: Plan, schedule: Schedule, positions: list[tuple[float, float]]) -> list[bool]:
    """Whether vehicle 0 is under attack in each step, by what `advance` returns."""
    active, result = False, []
    for step, position in enumerate(positions):
        starting, ending = plan.advance(schedule, ROWS[:1], np.array([position]), step)
        assert not (len(starting) and len(ending))
        active = (active or len(starting) > 0) and len(ending) == 0
        assert active == (schedule.state[0] == UNDER_ATTACK)
        result.append(active)
    return result


def test_first_step_at_a_time() -> None:
    clock = Clock(step_s=0.1, origin_s=100.0)
    assert [clock.step_at(t) for t in (100.0, 100.3, 100.31, 99.9)] == [0, 3, 4, -1]


def test_the_share_is_what_was_asked_for() -> None:
    for share in (0.0, 0.1, 0.5, 1.0):
        selected = make_plan(share=share).select(KEYS, ALL)
        spread = 4.5 * np.sqrt(share * (1.0 - share) / N)
        assert abs(selected.mean() - share) <= spread


def test_plans_with_equal_settings_attack_the_same_vehicles_in_the_same_windows() -> None:
    a, b = entered(make_plan("drift", share=0.5)), entered(make_plan("jamming", share=0.5, name="other"))
    assert np.array_equal(a.start_step, b.start_step)
    assert np.array_equal(a.end_step, b.end_step)
    fewer = entered(make_plan("drift", share=0.2))
    assert np.all(a.state[fewer.state == WAITING] == WAITING)


def test_a_vehicles_window_depends_on_its_key_alone() -> None:
    plan = make_plan(share=0.5)
    batch, mixed = entered(plan), Table(Schedule, N).now
    for part in (ROWS[::-2], ROWS[::2]):  # other rows, other order, other batches
        plan.enter(mixed, part, KEYS[part], ALL[part], 0, SECONDS)
    assert np.array_equal(batch.start_step, mixed.start_step)
    assert np.array_equal(batch.end_step, mixed.end_step)


def test_windows_are_uniform_and_counted_from_when_the_vehicle_has_settled() -> None:
    schedule = entered(make_plan(start_after_s=[2, 30], duration_s=[10, 20]), settled_step=100, clock=Clock(0.1))
    start_s = schedule.start_step * 0.1 - 10.0
    lasting_s = (schedule.end_step - schedule.start_step) * 0.1
    for drawn, least, most in ((start_s, 2.0, 30.0), (lasting_s, 10.0, 20.0)):
        width = most - least
        assert drawn.min() == pytest.approx(least, abs=width / 300)  # 4000 draws reach the ends
        assert drawn.max() == pytest.approx(most, abs=width / 300)
        assert drawn.mean() == pytest.approx((least + most) / 2, abs=4.5 * width / np.sqrt(12 * N))
    assert abs(np.corrcoef(start_s, lasting_s)[0, 1]) < 4.5 / np.sqrt(N)


def test_no_attack_begins_before_begin_or_lasts_beyond_end() -> None:
    plan = make_plan(begin_s=150.0, end_s=180.0, start_after_s=[0, 60], duration_s=[20, 20])
    schedule = entered(plan, settled_step=20, clock=Clock(step_s=1.0, origin_s=100.0))
    waiting = schedule.state == WAITING
    assert schedule.start_step[waiting].min() == 50  # 150 s is step 50
    assert schedule.start_step[waiting].max() == 79  # one second before the end
    assert schedule.end_step[waiting].max() == 80
    assert np.all((schedule.end_step - schedule.start_step)[waiting] <= 20)
    # Half of the 60 s in which attacks may begin lie before the end.
    assert waiting.mean() == pytest.approx(0.5, abs=0.05)
    assert np.all(schedule.start_step[~waiting] == NEVER)


def test_vehicles_of_other_types_are_spared() -> None:
    plan = make_plan(vehicle_types=["van", "truck"])
    assert [plan.aims_at(kind, "v") for kind in ("van", "car", "truck")] == [True, False, True]
    assert make_plan().aims_at("car", "v")


@pytest.mark.parametrize(
    ("vehicles", "aimed"),
    [
        (["v"], {"v"}),
        (["east.*"], {"east.0", "east.17"}),
        (["v", "east.?"], {"v", "east.0"}),
        (["[[]1]"], {"[1]"}),
    ],
)
def test_vehicles_are_aimed_at_by_their_ids(vehicles: list[str], aimed: set[str]) -> None:
    plan = make_plan(vehicles=vehicles)
    ids = ("v", "V", "east", "east.0", "east.17", "[1]", "1")
    assert {name for name in ids if plan.aims_at("car", name)} == aimed


def test_vehicles_and_types_must_both_fit() -> None:
    plan = make_plan(vehicles=["a*"], vehicle_types=["van"])
    found = [plan.aims_at(kind, name) for kind in ("van", "car") for name in ("a1", "b1")]
    assert found == [True, False, False, False]
    schedule = entered(plan, type_ok=ROWS % 4 == 0)
    assert np.array_equal(schedule.state != SPARED, ROWS % 4 == 0)


def test_an_attack_lasts_from_its_start_to_its_end_and_comes_once() -> None:
    plan = make_plan(start_after_s=[3, 3], duration_s=[4, 4])
    schedule = one(plan, settled_step=2)
    under_attack = follow(plan, schedule, [(0.0, 0.0)] * 20)
    assert under_attack == [5 <= step < 9 for step in range(20)]
    assert schedule.state[0] == ATTACKED
    assert (schedule.start_step[0], schedule.end_step[0]) == (5, 9)


def test_the_shortest_attack_is_one_step_long() -> None:
    plan = make_plan(start_after_s=[2, 2], duration_s=[0, 0])
    assert follow(plan, one(plan), [(0.0, 0.0)] * 5) == [False, False, True, False, False]


def test_each_vehicle_of_a_fleet_begins_and_ends_once() -> None:
    plan = make_plan(share=0.5, start_after_s=[0, 20], duration_s=[1, 15])
    schedule = entered(plan)
    planned = schedule.start_step.copy(), schedule.end_step.copy()
    begun, ended = np.zeros(N, int), np.zeros(N, int)
    for step in range(40):
        starting, ending = plan.advance(schedule, ROWS, np.zeros((N, 2)), step)
        assert np.all(planned[0][starting] == step)
        assert np.all(planned[1][ending] == step)
        begun[starting] += 1
        ended[ending] += 1
    assert np.array_equal(begun, (planned[0] != NEVER).astype(int))
    assert np.array_equal(ended, begun)


def test_only_the_rows_on_the_road_move_on_and_a_reset_row_is_spared() -> None:
    plan = make_plan(start_after_s=[0, 0])
    schedules = Table(Schedule, N)
    plan.enter(schedules.now, ROWS, KEYS, ALL, 0, SECONDS)
    starting, _ = plan.advance(schedules.now, ROWS[5:8], np.zeros((N, 2)), 0)
    assert starting.tolist() == [5, 6, 7]
    schedules.reset(ROWS[6:7])
    assert schedules.now.state[4:9].tolist() == [WAITING, UNDER_ATTACK, SPARED, UNDER_ATTACK, WAITING]


SQUARE = Zone("yard", np.array([[10.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0]]))
DRIVE_THROUGH = [(float(x), 5.0) for x in (0, 5, 11, 15, 19, 21, 15, 15)]


def test_in_a_zone_the_attack_lasts_while_the_vehicle_is_inside_and_comes_once() -> None:
    plan = make_plan(zone=SQUARE)
    schedule = one(plan)
    assert follow(plan, schedule, DRIVE_THROUGH) == [False, False, True, True, True, False, False, False]
    assert (schedule.start_step[0], schedule.end_step[0]) == (2, 5)


def test_in_a_zone_the_vehicle_must_have_settled() -> None:
    plan = make_plan(zone=SQUARE)
    assert follow(plan, one(plan, settled_step=4), DRIVE_THROUGH) == [False] * 4 + [True] + [False] * 3


def test_a_zone_is_switched_on_and_off() -> None:
    plan = make_plan(zone=SQUARE, begin_s=3.0, end_s=6.0)
    stay = [(15.0, 5.0)] * 9
    assert follow(plan, one(plan), stay) == [3 <= step < 6 for step in range(9)]


def test_nobody_is_attacked_in_a_zone_after_its_end() -> None:
    plan = make_plan(zone=SQUARE, end_s=2.0)
    assert not any(follow(plan, one(plan), DRIVE_THROUGH))


def test_the_share_holds_in_zones() -> None:
    plan = make_plan(zone=SQUARE, share=0.5)
    schedule = entered(plan)
    starting, _ = plan.advance(schedule, ROWS, np.tile([15.0, 5.0], (N, 1)), 0)
    assert np.array_equal(starting, ROWS[make_plan(share=0.5).select(KEYS, ALL)])


AROUND_VAN = Zone("van", np.zeros((0, 2)), radius_m=5.0, hold_s=2.0)


def follow_van(plan: Plan, schedule: Schedule, victim: list[float], vans: list[list[float]]) -> list[bool]:
    """Whether vehicle 0, at (x, 0) in each step, is under attack; the vans are at (x, 3)."""
    active, result = False, []
    for step, (x, others) in enumerate(zip(victim, vans, strict=True)):
        spoofers = {"van": np.array([[x, 3.0] for x in others]).reshape(-1, 2)} if others else {}
        starting, ending = plan.advance(schedule, ROWS[:1], np.array([[x, 0.0]]), step, spoofers)
        active = (active or len(starting) > 0) and len(ending) == 0
        result.append(active)
    return result


def test_a_spoofer_in_traffic_takes_whom_it_comes_near_and_holds_on_for_a_while() -> None:
    """In reach are 4 m along the road (3-4-5). Out of it in step 3, back in 4, out from step 6: held for two steps."""
    plan = make_plan(zone=AROUND_VAN)
    victim = [0.0] * 10
    vans = [[9.0], [4.0], [-4.0], [-5.0], [4.0], [0.0], [8.0], [4.1], [], [0.0]]
    active = [False, True, True, True, True, True, True, True, False, False]
    assert follow_van(plan, one(plan), victim, vans) == active


def test_in_reach_of_any_of_the_vans_and_of_those_of_its_plan_alone() -> None:
    plan = make_plan(zone=AROUND_VAN)
    assert follow_van(plan, one(plan), [0.0, 0.0], [[50.0, 60.0], [50.0, -1.0]]) == [False, True]
    near = {"other": np.zeros((1, 2))}
    assert not len(plan.advance(one(plan), ROWS[:1], np.zeros((1, 2)), 0, near)[0])


def test_a_spoofer_without_a_hold_lets_go_at_once() -> None:
    plan = make_plan(zone=Zone("van", np.zeros((0, 2)), radius_m=5.0))
    assert follow_van(plan, one(plan), [0.0] * 3, [[0.0], [9.0], [0.0]]) == [True, False, False]


def test_a_row_that_is_used_again_knows_nothing_of_its_last_vehicle() -> None:
    plan = make_plan(zone=AROUND_VAN)
    schedules = Table(Schedule, 1)
    schedule = schedules.now
    plan.enter(schedule, ROWS[:1], KEYS[:1], ALL[:1], 0, SECONDS)
    follow_van(plan, schedule, [0.0], [[0.0]])
    schedules.reset(ROWS[:1])
    plan.enter(schedule, ROWS[:1], KEYS[:1], ALL[:1], 1, SECONDS)
    assert schedule.inside_step[0] == -1
    assert follow_van(plan, schedule, [0.0, 0.0, 0.0], [[9.0], [9.0], [0.0]]) == [False, False, True]


def test_plans_of_a_run() -> None:
    configs = [
        plan_config({"attack": "replay", "delay_s": 7}, "t"),
        plan_config({"attack": "drift", "zone": "yard"}, "t"),
    ]
    drawn = [
        (plan_config({"attack": "jamming", "name": "yard", "zone": "yard"}, "t"), SQUARE, "b.add.xml: zone 'yard'")
    ]
    plans = build_plans(configs, drawn)
    assert [(plan.name, plan.zone) for plan in plans] == [("replay", None), ("drift", SQUARE), ("yard", SQUARE)]
    assert needed_memory_s(plans) == 7.0
    assert needed_memory_s(plans[1:]) == 0.0
    assert needed_memory_s([]) == 0.0


def test_plans_that_vehicles_carry_come_last_and_their_spoofers_are_zones() -> None:
    van = plan_config({"attack": "jamming", "name": "van", "zone": "van"}, "t")
    car = plan_config({"attack": "drift", "name": "v", "vehicles": ["v"]}, "t")
    near = plan_config({"attack": "drift", "zone": "van"}, "t")
    plans = build_plans([near], [], [(van, AROUND_VAN, "a.rou.xml: vType 'van'"), (car, None, "a.rou.xml: trip 'v'")])
    assert [(plan.name, plan.zone) for plan in plans] == [("drift", AROUND_VAN), ("van", AROUND_VAN), ("v", None)]
    with pytest.raises(GpsecError, match=r"^a\.rou\.xml: trip 'v': name: expected a name that no other plan has"):
        build_plans([], [], [(car, None, "x"), (car, None, "a.rou.xml: trip 'v'")])


def test_plans_that_do_not_go_together() -> None:
    drift = plan_config({"attack": "drift"}, "t")
    lost = plan_config({"attack": "drift", "zone": "yrd"}, "t")
    drawn = [
        (plan_config({"attack": "jamming", "name": "yard", "zone": "yard"}, "t"), SQUARE, "b.add.xml: zone 'yard'")
    ]
    with pytest.raises(
        GpsecError, match=r"^a\.toml: plans\[1\]: name: expected a name that no other plan has, found 'drift'"
    ):
        build_plans([drift, drift], config_file="a.toml")
    with pytest.raises(GpsecError, match=r"^b\.add\.xml: zone 'yard': name: .* found 'yard'"):
        build_plans([plan_config({"attack": "drift", "name": "yard"}, "t")], drawn)
    with pytest.raises(GpsecError, match=r"plans\[0\]: zone: .* found 'yrd': did you mean 'yard'\?"):
        build_plans([lost], drawn)
    with pytest.raises(GpsecError, match=r"found 'yrd': no zone is drawn"):
        build_plans([lost])
