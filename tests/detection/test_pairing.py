"""Which samples a residual is formed of, and when, on a straight road that leads east."""

from math import cos, pi, radians, sin, tan

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.pairing import DetectionClock, Pending, Sampling
from gpsec.detection.residual import Residuals
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import TRACKED
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

ONE_THREAD = Threads(1)
ROAD_Y_M = -1.6  # centre of the lane
STEPS_S = (0.2, 0.1, 0.07, 0.05, 0.033, 0.02, 0.01, 0.005, 0.001)


@pytest.fixture(scope="module")
def road(plain_net) -> HDMap:
    return compile_map(plain_net('id="a" x="0" y="0"\nid="b" x="900" y="0"', 'id="ab" from="a" to="b" speed="30"'), ())


class Ride:
    """One vehicle that drives straight on at an angle to its lane, with perfect sensors, and its residuals."""

    def __init__(self, road: HDMap, step_s: float, fix_hz: float = 10.0, camera_hz: float = 10.0) -> None:
        self.step_s, self.step = step_s, -1
        self.vehicles, self.seen, self.tracks = Table(Vehicles, 1).now, Table(Measurements, 1).now, Table(Tracks, 1).now
        self.tracks.lane[:], self.tracks.lane_known[:] = road.lane_index["ab_0"], True
        self.tracks.vehicle[:] = 0
        view = MapView(road.lanes, road.index, TRACKED, np.zeros(1, np.int32))
        self.residuals = Residuals(view, Sampling.of(step_s, [fix_hz], [camera_hz]))
        self.pending = Table(Pending).now
        self.yaw_rad, self.speed_mps = radians(5.0), 20.0
        self.seen.heading_rad[:], self.seen.speed_mps[:] = self.yaw_rad, self.speed_mps

    @property
    def place_m(self) -> np.ndarray:
        way_m = self.speed_mps * self.step_s * (self.step + 1)
        return np.array([50.0 + way_m * cos(self.yaw_rad), ROAD_Y_M - 1.0 + way_m * sin(self.yaw_rad)])

    def go(self, fix: bool, camera: bool, bias_m: float = 0.0) -> float | None:
        """Drive a step; return the residual that is formed in it."""
        self.step += 1
        x, y = self.place_m
        self.tracks.fix_m[0], self.tracks.fix_valid[0] = (x, y + bias_m), fix
        self.seen.camera_valid[0] = camera
        self.seen.lane_poly[0] = -(y - ROAD_Y_M) / cos(self.yaw_rad), -tan(self.yaw_rad), 0.0, 0.0
        rows = np.zeros(1, np.int32)
        self.residuals.update(self.step, self.pending, rows, self.tracks, self.vehicles, self.seen, ONE_THREAD)
        return float(self.tracks.residual_m[0]) if self.tracks.residual_valid[0] else None


@pytest.mark.parametrize("step_s", STEPS_S)
def test_the_clock_ticks_ten_times_a_second_or_in_every_step(step_s):
    clock = DetectionClock(step_s)
    ticks = [step for step in range(round(60.0 / step_s)) if clock.ticks(step)]
    assert len(ticks) == pytest.approx(min(600, round(60.0 / step_s)), abs=1)
    # A tick is in the first step that ends at a tenth of a second or after it.
    ends = [(step + 1) * step_s for step in ticks]
    wanted = [max((number + 1) * max(0.1, step_s), step_s) for number in range(len(ticks))]
    assert all(-1e-9 < end - tenth < step_s for end, tenth in zip(ends, wanted, strict=True))


def test_samples_may_be_as_old_as_a_period_of_their_sensor():
    sampling = Sampling.of(0.033, [10.0, 5.0], [30.0, 12.0])
    assert sampling.fix_steps.tolist() == [4, 7]
    assert sampling.camera_steps.tolist() == [2, 3]
    assert Sampling.of(0.1, [20.0], [30.0]).camera_steps.tolist() == [1]


@pytest.mark.parametrize(("fix_at", "camera_at"), [(0, 4), (4, 0), (3, 3)])
def test_samples_of_different_steps_are_compared_at_the_time_of_the_camera(road, fix_at, camera_at):
    """20 m/s at 5° to the lane: in 40 ms the vehicle moves 7 cm across it, which odometry accounts for."""
    ride = Ride(road, 0.01)
    found = [ride.go(step == fix_at, step == camera_at, 0.5) for step in range(10)]
    assert found[:9] == [None] * 9
    # 0.5 m to the north is 0.5 m across the lane, along the vehicle's lateral axis 0.5/cos 5°.
    assert found[9] == pytest.approx(-0.5 / cos(ride.yaw_rad), abs=1e-9)
    np.testing.assert_allclose(ride.tracks.paired_m[0], ride.place_m + np.array([0.0, 0.5]), atol=1e-9)


def test_samples_of_the_same_step_are_compared_as_they_are(road):
    ride = Ride(road, 0.1)
    assert ride.go(True, True, 0.5) == pytest.approx(-0.5 / cos(ride.yaw_rad), abs=1e-12)
    assert ride.tracks.paired_m.tobytes() == ride.tracks.fix_m.tobytes()


def test_a_sample_is_compared_once(road):
    ride = Ride(road, 0.1, fix_hz=5.0, camera_hz=20.0)
    assert ride.go(True, True) is not None
    assert ride.go(False, True) is None
    assert ride.go(True, True) is not None
    assert ride.go(True, False) is None
    assert ride.go(False, True) is not None


def test_steps_since_the_last_residual_are_counted(road):
    ride = Ride(road, 0.1)
    elapsed = []
    for camera in (False, True, True, False, False, True, True):
        ride.go(True, camera)
        elapsed.append(int(ride.pending.elapsed_steps[0]))
    assert elapsed == [1, 2, 1, 1, 2, 3, 1]


@pytest.mark.parametrize(("late", "formed"), [(10, True), (11, False)])
def test_a_sample_older_than_a_period_is_not_compared(road, late, formed):
    for first in ("fix", "camera"):
        ride = Ride(road, 0.01)
        for step in range(8 + late):
            found = ride.go(step == 8 and first == "fix", step == 8 and first == "camera")
            assert found is None
        assert (ride.go(first == "camera", first == "fix") is not None) == formed


@pytest.mark.parametrize("step_s", [0.1, 0.05, 0.033, 0.02, 0.01, 0.005])
@pytest.mark.parametrize("phase", [0.0, 0.13, 0.37, 0.5, 0.86])
@pytest.mark.parametrize(("fix_hz", "camera_hz", "wanted_hz"), [(10, 30, 10), (20, 20, 10), (10, 12, 10), (5, 20, 5)])
def test_clocks_do_not_decide_how_many_residuals_there_are(road, step_s, phase, fix_hz, camera_hz, wanted_hz):
    """Sensors of all profiles tick at any phase, at most once a step: ten residuals a second, or one for each fix."""

    def ticks(rate_hz: float, ahead: float, step: int) -> bool:
        per_step = min(rate_hz * step_s, 1.0)
        return int(ahead + per_step * (step + 1)) > int(ahead + per_step * step)

    ride = Ride(road, step_s, fix_hz, camera_hz)
    steps = round(12.0 / step_s)
    found = [ride.go(ticks(fix_hz, phase, step), ticks(camera_hz, 1.0 - phase, step)) for step in range(steps)]
    formed = [residual for residual in found if residual is not None]
    assert len(formed) == pytest.approx(12 * wanted_hz, abs=3)
    assert np.abs(formed).max() < 1e-9


def test_a_vehicle_that_turns_meanwhile_is_followed_along_its_arc(road):
    """A quarter of a circle in the period of a slow receiver: the fix of its begin is moved to its end."""
    ride = Ride(road, 0.01, fix_hz=1.0, camera_hz=20.0)
    radius_m, turn_rad = 10.0, pi / 2.0 / 100.0
    ride.seen.speed_mps[:] = radius_m * turn_rad / 0.01
    ride.seen.yaw_rate_rps[:] = turn_rad / 0.01
    ride.yaw_rad = ride.speed_mps = 0.0  # for the camera, which sees the same all the time
    found = None
    for step in range(101):
        ride.seen.heading_rad[:] = -pi / 2.0 + step * turn_rad
        found = ride.go(step == 0, step == 100)
    # It went 10 m to the south and 10 m to the east.
    np.testing.assert_allclose(ride.tracks.paired_m[0], ride.place_m + np.array([10.0, -10.0]), atol=1e-9)
    assert found is not None
