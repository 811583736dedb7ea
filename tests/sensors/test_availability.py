"""When a channel gives a sample: its clock, its outages, and what the camera can see."""

from math import exp, radians, sqrt

import numpy as np
import pytest

from gpsec.testing.drive import Drive
from tests.sensors.exact import profile


def valid_over(drive, steps, name="fix_valid"):
    return np.stack([getattr(drive.sense(), name).copy() for _ in range(steps)])


@pytest.mark.parametrize("rate_hz", [4.0, 5.0, 1.0])
def test_a_slow_channel_ticks_at_its_rate(rate_hz):
    valid = valid_over(Drive((profile(gnss={"rate_hz": rate_hz}),), 500), 200)
    ticks = valid.sum(axis=0)
    # In 20 s a clock of f Hz passes 20·f whole numbers, give or take the one at the edge.
    assert np.abs(ticks - 20.0 * rate_hz).max() <= 1
    gaps = np.diff(np.nonzero(valid[:, 0])[0])
    assert set(gaps) <= {int(10.0 / rate_hz), int(np.ceil(10.0 / rate_hz))}
    # Phases differ among vehicles: in each step, about the same share of them has a tick.
    share = rate_hz / 10.0
    assert np.abs(valid.mean(axis=1) - share).max() < 4.9 * sqrt(share * (1.0 - share) / 500)


def test_a_fast_channel_has_a_sample_in_every_step():
    assert valid_over(Drive((profile(gnss={"rate_hz": 10.0}, camera={"rate_hz": 30.0}),), 50), 50).all()


def test_between_fixes_the_last_one_stays():
    drive = Drive((profile(gnss={"rate_hz": 1.0}),))
    while not drive.sense().fix_valid[0]:
        drive.move(10.0, 0.0)
    at_fix = drive.measurements.fix_m.copy()
    drive.move(10.0, 0.0)
    assert not drive.sense().fix_valid[0]
    np.testing.assert_array_equal(drive.measurements.fix_m, at_fix)


def test_a_slow_heading_is_carried_on_by_the_gyro():
    drive = Drive((profile(heading={"rate_hz": 0.5, "white_deg": 1.0}),))
    drive.sense()
    error = drive.measurements.heading_rad[0] - drive.vehicles.yaw_rad[0]
    changes = 0
    for _ in range(39):
        drive.move(10.0, 0.2)
        new = drive.sense().heading_rad[0] - drive.vehicles.yaw_rad[0]
        changes += abs(new - error) > 1e-9
        error = new
    assert 1 <= changes <= 2


def test_slow_odometer_and_gyro_hold_their_last_value():
    drive = Drive((profile(odometer={"rate_hz": 1.0}, gyro={"rate_hz": 1.0}),))
    speeds, rates = [], []
    for k in range(21):
        drive.move(10.0 + k, 0.01 * k)
        measured = drive.sense()
        speeds.append(measured.speed_mps[0])
        rates.append(measured.yaw_rate_rps[0])
    assert speeds[0] == 10.0
    assert 3 <= len(set(speeds)) <= 4
    assert 3 <= len(set(rates)) <= 4


def test_outages_have_their_share_and_their_length():
    # 360 an hour of 2 s each: begin 0.01 and end 0.049 per step, about 17 % of the time.
    drive = Drive((profile(camera={"outages_per_h": 360.0, "outage_mean_s": 2.0}),), 2_000)
    seen = valid_over(drive, 200, "camera_valid")
    begin, end = 1.0 - exp(-0.01), 1.0 - exp(-0.05)
    share = begin / (begin + end)
    # The chain starts in its stationary distribution: the first step is like any other.
    assert 1.0 - seen[0].mean() == pytest.approx(share, abs=4.9 * sqrt(share * (1.0 - share) / 2_000))
    assert 1.0 - seen.mean() == pytest.approx(share, abs=0.01)
    # Given an outage, it is over in the next step with probability `end`.
    before, after = seen[:-1], seen[1:]
    assert (after & ~before).sum() / (~before).sum() == pytest.approx(end, rel=0.05)


def test_an_outage_of_no_length_is_a_single_missing_sample():
    drive = Drive((profile(gnss={"outages_per_h": 3_600.0, "outage_mean_s": 0.0}),), 500)
    valid = valid_over(drive, 100)
    assert not valid.all()
    # Sample by sample, an outage is followed by a sample; it never lasts two steps.
    assert not (~valid[:-1] & ~valid[1:]).any()


def test_camera_sees_no_lane_without_markings():
    drive = Drive((profile(),), 2)
    drive.vehicles.marked[0] = False
    np.testing.assert_array_equal(drive.sense().camera_valid, [False, True])
    assert drive.measurements.fix_valid.all()


def test_camera_sees_no_lane_across_its_view():
    drive = Drive((profile(),), 4)
    drive.vehicles.yaw_rad[:] = 3.0
    drive.vehicles.camera_yaw_rad[:] = 3.0 + np.radians([59.0, 61.0, -61.0, 180.0])
    np.testing.assert_array_equal(drive.sense().camera_valid, [True, False, False, False])


def test_camera_gives_up_where_its_sigma_passes_the_limit():
    drive = Drive((profile(camera={"white_m": 0.1, "trust_limit_m": 0.2, "field_of_view_deg": 60.0}),), 2)
    # σ doubles when a quarter of the 50 m is in view: at a curvature of 2·30°/12.5 m.
    limit = radians(60.0) / 12.5
    drive.vehicles.camera_curvature_per_m[:] = [limit * 0.999, limit * 1.001]
    np.testing.assert_array_equal(drive.sense().camera_valid, [True, False])
    assert drive.measurements.camera_sigma_m[0] == pytest.approx(0.2, rel=1e-3)


def test_camera_measures_the_lane_under_the_true_pose():
    drive = Drive((profile(gnss={"bias_m": 5.0}),))
    drive.vehicles.camera_offset_m[:] = 0.3
    drive.vehicles.camera_yaw_rad[:] = 0.1
    drive.vehicles.camera_curvature_per_m[:] = 0.02
    poly = drive.sense().lane_poly[0]
    c, t = np.cos(0.1), np.tan(0.1)
    np.testing.assert_allclose(poly, [-0.3 / c, t, 0.01 / c**3, 0.0002 * t / c**4], rtol=1e-12)
