"""Each channel's noise against its profile, over 40,000 vehicles at once."""

from math import exp, pi, sqrt

import numpy as np
import pytest

from gpsec.pipeline.filter_noise import filter_noise
from gpsec.testing.contract import STEP_S
from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

N = 40_000
# For what takes many steps.
FEW = 4_000
# A sample standard deviation of N normal draws is within this of σ in all but 1 in 10^6 cases (4.9 standard errors).
TOLERANCE = 4.9 / sqrt(2.0 * N)


def one_step(**changes):
    drive = Drive((profile(**changes),), N)
    drive.vehicles.speed_mps[:] = 10.0
    drive.sense()
    return drive


def assert_sigma(errors, sigma):
    assert np.std(errors) == pytest.approx(sigma, rel=TOLERANCE)
    assert abs(np.mean(errors)) < 4.9 * sigma / sqrt(N)


@pytest.mark.parametrize("kind", ["white_m", "bias_m"])
def test_gnss(kind):
    fix = one_step(gnss={kind: 0.5}).measurements.fix_m
    assert_sigma(fix[:, 0], 0.5)
    assert_sigma(fix[:, 1], 0.5)
    assert abs(np.corrcoef(fix.T)[0, 1]) < 4.9 / sqrt(N)


def test_gyro_white_noise_is_the_angle_random_walk():
    drive = one_step(gyro={"angle_random_walk_deg_per_sqrt_h": 0.6})
    assert_sigma(drive.measurements.yaw_rate_rps, 0.6 / 60.0 * pi / 180.0 / sqrt(STEP_S))


def test_gyro_bias():
    drive = one_step(gyro={"bias_deg_per_h": 10.0})
    assert_sigma(drive.measurements.yaw_rate_rps, 10.0 * pi / 180.0 / 3600.0)


def test_odometer_scale_multiplies_and_white_noise_adds():
    assert_sigma(one_step(odometer={"scale_ratio": 0.01}).measurements.speed_mps - 10.0, 0.1)
    assert_sigma(one_step(odometer={"white_mps": 0.05}).measurements.speed_mps - 10.0, 0.05)


@pytest.mark.parametrize("kind", ["white_deg", "bias_deg"])
def test_heading(kind):
    assert_sigma(one_step(heading={kind: 0.2}).measurements.heading_rad, 0.2 * pi / 180.0)


@pytest.mark.parametrize("kind", ["white_m", "bias_m", "mount_m"])
def test_camera_offset(kind):
    assert_sigma(one_step(camera={kind: 0.05}).measurements.lane_poly[:, 0], 0.05)


def test_camera_states_its_true_sigma_in_a_bend():
    drive = Drive((profile(camera={"white_m": 0.06, "bias_m": 0.03, "mount_m": 0.04}),), N)
    drive.vehicles.camera_curvature_per_m[:] = 1.0 / 12.0
    poly = drive.sense().lane_poly
    stated = drive.measurements.camera_sigma_m
    assert np.ptp(stated) == 0.0
    assert_sigma(poly[:, 0], stated[0])
    # 60° of view at a radius of 12 m: 4π m instead of the full 50 m.
    assert stated[0] == pytest.approx(sqrt(0.06**2 * 50.0 / (4.0 * pi) + 0.03**2 + 0.04**2), rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "read", "tau_s"),
    [
        ({"gnss": {"bias_m": 1.0, "bias_tau_s": 2.0}}, lambda m: m.fix_m[:, 1], 2.0),
        ({"gyro": {"bias_deg_per_h": 1.0, "bias_tau_s": 0.5}}, lambda m: m.yaw_rate_rps, 0.5),
        ({"heading": {"bias_deg": 1.0, "bias_tau_s": 1.0}}, lambda m: m.heading_rad, 1.0),
        ({"camera": {"bias_m": 0.1, "bias_tau_s": 1.0}}, lambda m: m.lane_poly[:, 0], 1.0),
    ],
)
def test_biases_are_gauss_markov(changes, read, tau_s):
    drive = Drive((profile(**changes),), N)
    before = read(drive.sense()).copy()
    for _ in range(10):
        drive.sense()
    after = read(drive.measurements)
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(exp(-1.0 / tau_s), abs=4.9 / sqrt(N))
    assert np.std(after) == pytest.approx(np.std(before), rel=2.0 * TOLERANCE)


def test_white_noise_is_new_in_each_step_and_constants_are_not():
    drive = Drive((profile(gnss={"white_m": 1.0}, camera={"mount_m": 0.1}, odometer={"scale_ratio": 0.01}),), N)
    drive.vehicles.speed_mps[:] = 10.0
    first = drive.sense()
    fix, mount, speed = first.fix_m[:, 0].copy(), first.lane_poly[:, 0].copy(), first.speed_mps.copy()
    second = drive.sense()
    assert abs(np.corrcoef(fix, second.fix_m[:, 0])[0, 1]) < 4.9 / sqrt(N)
    np.testing.assert_array_equal(second.lane_poly[:, 0], mount)
    np.testing.assert_array_equal(second.speed_mps, speed)


def test_channels_are_independent_of_each_other():
    drive = one_step(
        gnss={"white_m": 1.0, "bias_m": 1.0},
        gyro={"angle_random_walk_deg_per_sqrt_h": 1.0},
        odometer={"white_mps": 1.0},
        heading={"white_deg": 1.0},
        camera={"white_m": 1.0},
    )
    m = drive.measurements
    errors = np.column_stack([m.fix_m, m.speed_mps, m.yaw_rate_rps, m.heading_rad, m.lane_poly])
    off_diagonal = np.corrcoef(errors.T) - np.eye(9)
    assert np.abs(off_diagonal).max() < 4.9 / sqrt(N)


@pytest.mark.parametrize("step_s", [0.1, 0.01, 0.005, 0.002])
def test_the_gyro_s_angle_walks_alike_at_every_step(step_s):
    """After a second the angle is off by ARW·√(1 s), also where samples of 10 ms are held for several steps."""
    drive = Drive((profile(gyro={"angle_random_walk_deg_per_sqrt_h": 0.6, "rate_hz": 100.0}),), FEW, step_s=step_s)
    angle = np.zeros(FEW)
    for _ in range(round(1.0 / step_s)):
        angle += drive.sense().yaw_rate_rps * step_s
    # A sample that is held on beyond the end, or came before the begin, is there for a part of its time.
    assert np.std(angle) == pytest.approx(0.6 / 60.0 * pi / 180.0, rel=4.9 / sqrt(2.0 * FEW))


@pytest.mark.parametrize("step_s", [0.1, 0.01, 0.005, 0.002])
def test_filters_are_told_how_far_the_odometer_strays(step_s):
    """The process noise of a second adds up to the error that the held samples make of the way."""
    entry = profile(odometer={"white_mps": 0.1, "rate_hz": 100.0})
    drive = Drive((entry,), FEW, step_s=step_s)
    steps = round(1.0 / step_s)
    way_m = np.zeros(FEW)
    for _ in range(steps):
        way_m += drive.sense().speed_mps * step_s
    told_m = filter_noise(entry, step_s).odometer_white_mps * step_s * sqrt(steps)
    assert np.std(way_m) == pytest.approx(told_m, rel=4.9 / sqrt(2.0 * FEW))
