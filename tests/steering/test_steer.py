"""Who is steered, since when, and back to SUMO: attacks, alarms and errors by hand."""

import numpy as np
import pytest

from gpsec.steering.driving_on import DriveOn
from gpsec.steering.second_order import SecondOrder
from gpsec.steering.steer import Drivers, Steering
from gpsec.steering.stopping import PullOver, StopInLane


def drive(steering, steps, rows=(4, 1), **over):
    """Let two vehicles drive; `over` maps a field of `Drivers` to a function of the step that gives both values."""
    rows = np.array(rows, np.int32)
    steering.enter(rows)
    wishes = []
    for step in range(steps):
        values = {
            "key": np.array([3, 4], np.uint64),
            "settled": np.array([True, True]),
            "attacked": np.array([False, False]),
            "alarm": np.array([False, False]),
            "error_m": np.zeros(2),
            "edge_m": np.full(2, -1.6),
            "speed_mps": np.full(2, 12.0),
            "wrecked": np.array([False, False]),
        }
        values |= {name: np.array(give(step)) for name, give in over.items()}
        wishes.append(steering.update(step, Drivers(rows, **values)))
    return wishes


def steering(reaction=None, everybody=False):
    return Steering(0.1, SecondOrder(), reaction or DriveOn(), everybody=everybody)


def test_an_attacked_vehicle_goes_where_its_estimate_leads_and_comes_back():
    """An error of 2 m to the left from step 10 to 99 puts the first vehicle 2 m to the right."""
    wishes = drive(
        steering(),
        300,
        attacked=lambda k: [10 <= k < 100, False],
        error_m=lambda k: [2.0 if 10 <= k < 100 else 0.0, 0.4],
    )
    assert all(not len(wish.rows) for wish in wishes[:10])
    assert [wish.rows.tolist() for wish in wishes[10:120]] == [[4]] * 110
    assert wishes[99].offset_m[0] == pytest.approx(-2.0, abs=0.01)
    (released,) = [k for k, wish in enumerate(wishes) if len(wish.released)]
    assert 120 < released < 150
    assert wishes[released].released.tolist() == [4]
    assert not len(wishes[released].rows)
    assert abs(wishes[released - 1].offset_m[0]) < 0.08


def test_an_error_that_stays_steers_for_half_a_minute_at_most():
    wishes = drive(steering(), 450, attacked=lambda k: [k < 5, False], error_m=lambda k: [1.0, 0.0])
    assert wishes[300].offset_m[0] == pytest.approx(-1.0, abs=0.01)
    assert next(k for k, wish in enumerate(wishes) if len(wish.released)) in range(306, 360)


def test_honest_errors_move_everybody_where_all_steer():
    wishes = drive(steering(everybody=True), 80, error_m=lambda k: [0.3, -0.2], settled=lambda k: [k >= 20, True])
    assert wishes[19].rows.tolist() == [1]
    np.testing.assert_allclose(wishes[-1].offset_m, [-0.3, 0.2], atol=1e-3)


def test_with_an_estimate_that_is_true_nobody_moves():
    assert not any(wish.offset_m.any() for wish in drive(steering(everybody=True), 50))


def test_a_false_alarm_takes_the_vehicle_stops_it_and_gives_it_back():
    wishes = drive(steering(StopInLane(hold_s=1.0)), 60, alarm=lambda k: [False, 5 <= k < 8])
    assert [k for k, wish in enumerate(wishes) if wish.rows.tolist() == [1]] == list(range(5, 18))
    assert all(wish.brake_mps2.tolist() == [2.0] for wish in wishes[5:18])
    assert wishes[18].released.tolist() == [1]


def test_a_vehicle_that_pulls_over_goes_to_the_edge_and_back():
    wishes = drive(steering(PullOver(hold_s=0.0)), 200, alarm=lambda k: [5 <= k < 100, False])
    assert wishes[99].offset_m[0] == pytest.approx(-1.6, abs=0.01)
    assert [wish.released.tolist() for wish in wishes if len(wish.released)] == [[4]]


def test_a_wreck_stays_where_it_is():
    wishes = drive(
        steering(),
        100,
        attacked=lambda k: [k < 60, False],
        error_m=lambda k: [2.0, 0.0],
        wrecked=lambda k: [k >= 20, False],
    )
    assert len({wish.offset_m[0] for wish in wishes[20:]}) == 1
    assert not any(len(wish.released) for wish in wishes)


def test_a_row_that_is_entered_begins_anew():
    one = steering()
    drive(one, 50, attacked=lambda k: [True, True], error_m=lambda k: [2.0, 2.0])
    one.enter(np.array([4], np.int32))
    assert not one.now.driven[4]
    assert one.now.driven[1]


def test_a_delay_moves_everything_that_much_later():
    """Half a second: the same way from step 15 as it is from step 10 without, while the vehicle is steered."""
    wishes = [
        drive(
            Steering(0.1, SecondOrder(), DriveOn(), everybody=True, delay_s=delay_s),
            80,
            error_m=lambda k: [2.0 if k >= 10 else 0.0, 0.0],
        )
        for delay_s in (0.0, 0.5)
    ]
    at_once, later = (np.array([wish.offset_m for wish in made]) for made in wishes)
    assert at_once[10, 0] < 0.0
    np.testing.assert_array_equal(later[5:], at_once[:-5])
    assert not later[:15].any()
