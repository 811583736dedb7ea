"""The lag against the single-track model of CommonRoad under the control law of Stanley, and by hand."""

from math import atan, radians, sin

import numpy as np
import pytest
from vehiclemodels.init_st import init_st
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st

from gpsec.attacks.stealth import Stealth
from gpsec.steering.base import LateralMotion
from gpsec.steering.second_order import SecondOrder

FINE_S, STEP_S, CONTROL_S, DELAY_S = 0.005, 0.1, 0.05, 0.1
# Hoffmann, Tomlin, Montemerlo and Thrun, ACC 2007: gain, softening and damping of the yaw rate.
GAIN_PER_S, SOFT_MPS, DAMPING_S = 1.0, 1.0, 0.1
ROOM = Stealth()


def stealth(t):
    return min(ROOM.gamma_m * ROOM.delta ** (t / 0.1), ROOM.cap_m)


def drift(t):
    return min(0.2 * t, 5.0)


def single_track(speed_mps, error, seconds):
    """Displacement every 0.1 s of a car that steers by an estimate with `error(t)`."""
    car = parameters_vehicle2()
    x = init_st([0.0, 0.0, 0.0, speed_mps, 0.0, 0.0, 0.0])
    waiting, asked, found = [0.0] * round(DELAY_S / FINE_S), 0.0, []
    for k in range(round(seconds / FINE_S)):
        if k % round(CONTROL_S / FINE_S) == 0:
            across = x[1] + car.a * sin(x[4]) + error(k * FINE_S)
            asked = -x[4] - atan(GAIN_PER_S * across / (SOFT_MPS + speed_mps)) - DAMPING_S * x[5]
        waiting.append(asked)
        slope = vehicle_dynamics_st(x, [(waiting.pop(0) - x[2]) / FINE_S, 0.0], car)
        x = [value + FINE_S * rate for value, rate in zip(x, slope, strict=True)]
        if (k + 1) % round(STEP_S / FINE_S) == 0:
            found.append(x[1])
    return np.array(found)


def lag(speed_mps, error, seconds, dynamics=None, step_s=STEP_S):
    dynamics = dynamics or SecondOrder()
    state, y, rate, found = dynamics.new_state(1), np.zeros(1), np.zeros(1), []
    for k in range(round(seconds / step_s)):
        wanted = np.array([-error(k * step_s)])
        motion = LateralMotion(np.zeros(1, np.int32), step_s, y, rate, wanted, np.array([speed_mps]))
        moved = dynamics.apply(motion, state.now)
        y, rate = moved.offset_m, moved.rate_mps
        found.append(y[0])
    return np.array(found)


def crossing_s(way_m):
    return STEP_S * int(np.argmax(np.abs(way_m) > 1.0))


@pytest.mark.parametrize("speed_mps", [8.0, 14.0, 25.0, 33.0])
@pytest.mark.parametrize("error", [stealth, drift])
def test_it_moves_as_the_single_track_model_does(speed_mps, error):
    car, ours = single_track(speed_mps, error, 20.0), lag(speed_mps, error, 20.0)
    assert np.sqrt(np.mean((car - ours) ** 2)) <= 0.12
    assert abs(crossing_s(car) - crossing_s(ours)) <= 0.6
    assert abs(car[-1]) > 2.0


def test_it_goes_where_it_is_wanted_and_stays_there():
    way = lag(10.0, lambda t: -2.0, 10.0)
    assert way[-1] == pytest.approx(2.0, abs=1e-3)
    assert way.max() < 2.05  # critically damped, but for the length of a step


def test_acceleration_and_heading_are_bounded():
    way = lag(5.0, lambda t: -20.0, 5.0)
    rate = np.diff(way, prepend=0.0) / STEP_S
    assert np.abs(rate).max() == pytest.approx(5.0 * sin(radians(15.0)))
    assert np.diff(rate, prepend=0.0).max() / STEP_S == pytest.approx(3.0)


def test_who_stands_does_not_move():
    assert not lag(0.4, lambda t: 3.0, 2.0).any()


def test_slow_vehicles_are_slower_to_follow():
    fast, slow = lag(10.0, lambda t: -0.5, 1.0), lag(3.0, lambda t: -0.5, 1.0)
    assert 0.0 < slow[-1] < 0.7 * fast[-1]
