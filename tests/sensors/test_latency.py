"""What is old when it arrives is carried on by the vehicle's own odometer, gyro and heading."""

from math import pi

import numpy as np
import pytest

from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

LATE = {"gnss": {"latency_s": 0.25}, "camera": {"latency_s": 0.25}}


def drive_on(drive, speed_mps, yaw_rate_rps, steps=8):
    for _ in range(steps):
        drive.move(speed_mps, yaw_rate_rps)
        drive.sense()
    return drive.measurements


def test_perfect_odometry_aligns_a_late_fix_and_lane_exactly():
    drive = Drive((profile(**LATE),))
    drive.vehicles.yaw_rad[:] = 3.0  # passes π on the way
    measured = drive_on(drive, 20.0, 0.3)
    np.testing.assert_allclose(measured.fix_m, drive.vehicles.rear_m, atol=1e-12)
    yaw = drive.vehicles.yaw_rad[0]
    assert measured.heading_rad[0] == pytest.approx(yaw - 2.0 * pi, abs=1e-12)
    drive.move(20.0, 0.3)
    drive.vehicles.camera_yaw_rad[:] = drive.vehicles.yaw_rad + 0.05
    drive.vehicles.camera_offset_m[:] = 0.4
    poly = drive.sense().lane_poly[0]
    np.testing.assert_allclose(poly, [-0.4 / np.cos(0.05), np.tan(0.05), 0.0, 0.0], atol=1e-12)


def test_a_scale_error_of_the_odometer_stretches_what_was_driven_meanwhile():
    drive = Drive((profile(**LATE, odometer={"scale_ratio": 0.01}),), 5)
    drive.vehicles.yaw_rad[:] = pi / 2.0
    drive.vehicles.camera_yaw_rad[:] = pi / 2.0 + 0.1
    measured = drive_on(drive, 20.0, 0.0)
    ahead = 20.0 * 0.25 * drive.state.now.odometer_scale
    assert np.abs(ahead).max() > 0.01
    np.testing.assert_allclose(measured.fix_m[:, 1] - drive.vehicles.rear_m[:, 1], ahead, atol=1e-12)
    np.testing.assert_allclose(measured.fix_m[:, 0], 0.0, atol=1e-12)
    # The vehicle believes to be further along a lane that leads to the left, so that the lane seems further left.
    np.testing.assert_allclose(measured.lane_poly[:, 0], ahead * np.tan(0.1), atol=1e-12)


def test_a_heading_error_turns_what_was_driven_meanwhile():
    drive = Drive((profile(**LATE, heading={"bias_deg": 1.0, "bias_tau_s": 1e6}),), 5)
    measured = drive_on(drive, 20.0, 0.0)
    error = drive.state.now.heading_bias_rad
    np.testing.assert_allclose(measured.fix_m[:, 1], 5.0 * np.sin(error), rtol=1e-3)
    # The camera's own image does not care where north is.
    np.testing.assert_allclose(measured.lane_poly, 0.0, atol=1e-12)


def test_a_gyro_error_turns_the_carried_lane():
    drive = Drive((profile(**LATE, gyro={"bias_deg_per_h": 9_000.0, "bias_tau_s": 1e6}),), 5)
    measured = drive_on(drive, 20.0, 0.0)
    # Believing to turn left by ω for L, while driving straight at v, the lane's place in the vehicle frame turns
    # right by ωL, and shifts right by v·ω·L²/2.
    turned = drive.state.now.gyro_bias_rps * 0.25
    assert np.abs(turned).max() > 0.005
    np.testing.assert_allclose(measured.lane_poly[:, 1], -np.tan(turned), atol=2e-5)
    np.testing.assert_allclose(measured.lane_poly[:, 0], -20.0 * turned * 0.25 / 2.0, atol=5e-5)


def test_a_vehicle_that_just_entered_is_taken_to_have_stood_still():
    drive = Drive((profile(**LATE, odometer={"scale_ratio": 0.05}),))
    drive.move(20.0, 0.0)
    np.testing.assert_array_equal(drive.sense().fix_m, drive.vehicles.rear_m)
    assert drive.measurements.fix_valid[0]


def test_odometer_and_gyro_report_the_mean_of_an_older_window():
    drive = Drive((profile(odometer={"latency_s": 0.02}, gyro={"latency_s": 0.05}),))
    drive.move(10.0, 0.1)
    drive.sense()
    drive.move(11.0, 0.3)
    measured = drive.sense()
    assert measured.speed_mps[0] == pytest.approx(0.8 * 11.0 + 0.2 * 10.0)
    assert measured.yaw_rate_rps[0] == pytest.approx(0.5 * 0.3 + 0.5 * 0.1)


def test_a_late_heading_is_carried_on_by_the_gyro():
    drive = Drive((profile(heading={"latency_s": 0.05}, gyro={"bias_deg_per_h": 9_000.0}),))
    drive_on(drive, 10.0, 0.2)
    error = drive.measurements.heading_rad - drive.vehicles.yaw_rad
    np.testing.assert_allclose(error, 0.05 * drive.state.now.gyro_bias_rps, rtol=1e-9)


def test_odometer_and_gyro_may_be_late_by_several_steps():
    drive = Drive((profile(odometer={"latency_s": 0.025}, gyro={"latency_s": 0.02}),), step_s=0.01)
    for step in range(6):
        drive.move(10.0 + step, 0.1 * step)
        measured = drive.sense()
        # Two and a half steps ago, two steps ago; before it entered the vehicle moved as in its first step.
        older, newer = max(step - 3, 0), max(step - 2, 0)
        assert measured.speed_mps[0] == pytest.approx(10.0 + 0.5 * (older + newer))
        assert measured.yaw_rate_rps[0] == pytest.approx(0.1 * newer)


def test_a_heading_that_is_late_by_several_steps_is_carried_on_by_the_gyro():
    late = profile(heading={"latency_s": 0.025}, gyro={"bias_deg_per_h": 9_000.0, "bias_tau_s": 1e6})
    drive = Drive((late,), step_s=0.01)
    drive_on(drive, 10.0, 0.2)
    error = drive.measurements.heading_rad - drive.vehicles.yaw_rad
    np.testing.assert_allclose(error, 0.025 * drive.state.now.gyro_bias_rps, rtol=1e-3)
