from math import asin, atan2, cos, exp, hypot, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.core.geo import wrap_angle
from gpsec.core.tables import Table
from gpsec.traffic.body import advance, axle_distance, follow
from gpsec.types.vehicles import Vehicles

STEP_S = 0.1
lengths = st.floats(1.0, 8.6)


def integrate(phi: float, moved: float, axle: float, pieces: int = 400) -> tuple[float, float]:
    """Turn and way by Runge-Kutta of yaw' = sin(φ)/L and way' = cos(φ) over the way of the front, φ = course - yaw."""
    d, turn, way = moved / pieces, 0.0, 0.0

    def rate(angle: float) -> float:
        return sin(phi - angle) / axle

    for _ in range(pieces):
        k1 = rate(turn)
        k2 = rate(turn + 0.5 * d * k1)
        k3 = rate(turn + 0.5 * d * k2)
        k4 = rate(turn + d * k3)
        after = turn + d / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        middle = turn + 0.5 * d * k2
        way += d / 6.0 * (cos(phi - turn) + 4.0 * cos(phi - middle) + cos(phi - after))
        turn = after
    return turn, way


@given(st.floats(-3.1, 3.1), st.floats(-pi, pi), st.floats(0.0, 5.0), lengths)
def test_follow_is_the_tractrix(phi, yaw, moved, axle):
    turn, way = follow(yaw, yaw + phi, moved, axle)
    expected_turn, expected_way = integrate(wrap_angle(phi), moved, axle)
    assert turn == pytest.approx(expected_turn, abs=1e-6)
    assert way == pytest.approx(expected_way, abs=1e-5)


@given(st.floats(-pi / 2, pi / 2), st.floats(0.01, 5.0), lengths)
def test_the_rear_axle_never_takes_a_short_cut_nor_turns_past_the_course(phi, moved, axle):
    turn, way = follow(0.0, phi, moved, axle)
    rear = moved * cos(phi) - axle * (cos(turn) - 1.0), moved * sin(phi) - axle * sin(turn)
    assert abs(turn) <= abs(phi) + 1e-12
    assert hypot(*rear) <= way + 1e-9
    assert way <= moved + 1e-9


def test_pushed_back_the_body_does_not_turn():
    assert follow(0.0, pi, 0.7, 3.0) == (0.0, -0.7)
    assert follow(1.0, 1.0 - pi, 0.7, 3.0)[1] == pytest.approx(-0.7)


def body(yaw: float = 0.0, axle: float = 3.5, count: int = 1) -> Vehicles:
    vehicles = Table(Vehicles, count).now
    vehicles.yaw_rad[:] = yaw
    vehicles.axle_m[:] = axle
    return vehicles


def move(vehicles: Vehicles, front: np.ndarray, rows=None) -> None:
    rows = np.arange(len(front), dtype=np.int32) if rows is None else np.array(rows, np.int32)
    advance(rows, np.asarray(front, float), STEP_S, vehicles)


def test_a_fresh_body_is_placed_behind_its_front_at_sumos_speed():
    vehicles = body(yaw=pi / 2)
    vehicles.speed_mps[0] = 7.0
    move(vehicles, [[10.0, 20.0]])
    assert vehicles.rear_m[0] == pytest.approx([10.0, 16.5])
    assert (vehicles.speed_mps[0], vehicles.yaw_rate_rps[0], vehicles.fresh[0]) == (7.0, 0.0, False)


@pytest.mark.parametrize("left", [1.0, -1.0])
@pytest.mark.parametrize(("radius", "axle", "speed"), [(12.0, 3.5, 5.0), (40.0, 8.6, 10.0), (300.0, 3.6, 30.0)])
def test_steady_circle(radius, axle, speed, left):
    """The rear axle runs on sqrt(R² - L²) and the body turns by the angle that the front turns by in a step."""
    vehicles = body(axle=axle)
    angle = 2.0 * asin(speed * STEP_S / (2.0 * radius))
    steps = int(12.0 * axle / (speed * STEP_S)) + 50
    for step in range(steps):
        a = step * angle
        move(vehicles, [[radius * sin(a), left * radius * (1.0 - cos(a))]])
    rear = sqrt(radius**2 - axle**2)
    # A front that moves on chords is within d²/8R of the circle.
    assert hypot(vehicles.rear_m[0, 0], vehicles.rear_m[0, 1] - left * radius) == pytest.approx(
        rear, abs=(speed * STEP_S) ** 2 / (8.0 * radius) + 1e-6
    )
    assert vehicles.yaw_rate_rps[0] == pytest.approx(left * angle / STEP_S, rel=1e-6)
    assert vehicles.speed_mps[0] == pytest.approx(rear / radius * speed, rel=1e-3)


def test_straight_ahead():
    vehicles = body(yaw=0.3)
    for step in range(20):
        move(vehicles, [[1.4 * step * cos(0.3), 1.4 * step * sin(0.3)]])
    assert vehicles.yaw_rad[0] == pytest.approx(0.3, abs=1e-12)
    assert vehicles.speed_mps[0] == pytest.approx(14.0)
    assert vehicles.yaw_rate_rps[0] == pytest.approx(0.0, abs=1e-12)


def test_standing_still():
    vehicles = body(yaw=0.3)
    vehicles.speed_mps[0] = 9.0
    move(vehicles, [[5.0, 5.0]])
    rear = vehicles.rear_m.copy()
    move(vehicles, [[5.0, 5.0]])
    assert (vehicles.speed_mps[0], vehicles.yaw_rate_rps[0]) == (0.0, 0.0)
    assert vehicles.rear_m.tobytes() == rear.tobytes()


def test_a_lane_change_in_one_step_turns_the_body_only_as_far_as_the_tractrix_does():
    vehicles = body(axle=3.5)
    move(vehicles, [[0.0, 0.0]])
    move(vehicles, [[1.4, 3.5]])
    phi, moved = atan2(3.5, 1.4), hypot(3.5, 1.4)
    left = 2.0 * atan2(sin(phi / 2) * exp(-moved / 3.5), cos(phi / 2))
    assert vehicles.yaw_rad[0] == pytest.approx(phi - left)


def test_yaw_stays_wrapped_on_a_long_circle():
    vehicles = body()
    for step in range(2000):
        move(vehicles, [[20.0 * sin(0.02 * step), 20.0 * (1.0 - cos(0.02 * step))]])
        assert -pi <= vehicles.yaw_rad[0] < pi
        assert vehicles.yaw_rate_rps[0] >= 0.0


def test_a_body_does_not_depend_on_the_others():
    rng = np.random.default_rng(4)
    fronts = np.cumsum(rng.normal(0.0, 1.0, (30, 50, 2)), axis=0)
    together, alone = body(count=50), body(count=50)
    for front in fronts:
        move(together, front)
    order = rng.permutation(50)[:17]
    for front in fronts:
        move(alone, front[order], rows=order)
    for name in ("rear_m", "yaw_rad", "speed_mps", "yaw_rate_rps"):
        assert getattr(alone, name)[order].tobytes() == getattr(together, name)[order].tobytes()
    untouched = np.setdiff1d(np.arange(50), order)
    assert alone.fresh[untouched].all()


@pytest.mark.parametrize(("length", "axle"), [(4.6, 3.588), (2.0, 1.56), (12.0, 8.6), (16.5, 8.6)])
def test_axle_distance(length, axle):
    assert axle_distance(length) == pytest.approx(axle)
