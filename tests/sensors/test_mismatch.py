"""Sensors that are not as their data sheets say."""

from math import sqrt

import numpy as np
import pytest

from gpsec.sensors.mismatch import AS_STATED, Mismatch
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.sense import Sensors
from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

N = 20_000
# As in test_noise: 4.9 standard errors of a sample standard deviation, of both that are compared.
TOLERANCE = 4.9 / sqrt(N)


def measured(mismatch, **changes):
    drive = Drive((profile(**changes),), N, mismatch=mismatch)
    drive.vehicles.speed_mps[:] = 10.0
    drive.sense()
    return drive.measurements


@pytest.mark.parametrize(
    ("factor", "changes", "read"),
    [
        ("gnss_white", {"gnss": {"white_m": 0.1}}, lambda m: m.fix_m[:, 0]),
        ("gnss_slow", {"gnss": {"bias_m": 0.1}}, lambda m: m.fix_m[:, 1]),
        ("camera", {"camera": {"white_m": 0.06}}, lambda m: m.lane_poly[:, 0]),
        ("camera", {"camera": {"white_m": 0.06}}, lambda m: m.lane_poly[:, 1]),
        ("camera", {"camera": {"bias_m": 0.06}}, lambda m: m.lane_poly[:, 0]),
        ("camera", {"camera": {"mount_m": 0.06}}, lambda m: m.lane_poly[:, 0]),
        ("odometer", {"odometer": {"white_mps": 0.1}}, lambda m: m.speed_mps),
        ("odometer", {"odometer": {"scale_ratio": 0.01}}, lambda m: m.speed_mps),
        ("gyro", {"gyro": {"angle_random_walk_deg_per_sqrt_h": 0.6}}, lambda m: m.yaw_rate_rps),
        ("gyro", {"gyro": {"bias_deg_per_h": 10.0}}, lambda m: m.yaw_rate_rps),
        ("heading", {"heading": {"white_deg": 0.2}}, lambda m: m.heading_rad),
        ("heading", {"heading": {"bias_deg": 0.2}}, lambda m: m.heading_rad),
    ],
)
def test_a_factor_is_on_the_standard_deviation(factor, changes, read):
    stated, true = (np.std(read(measured(world, **changes))) for world in (AS_STATED, Mismatch(**{factor: 2.0})))
    assert true == pytest.approx(2.0 * stated, rel=1e-6)  # the same draws
    others = set(Mismatch.__dataclass_fields__) - {factor, "common_share"}
    alone = measured(Mismatch(**dict.fromkeys(others, 3.0)), **changes)
    assert np.std(read(alone)) == pytest.approx(stated, rel=1e-6)


def test_a_slow_error_that_lasts_is_larger_by_the_factor():
    drive = Drive((profile(gnss={"bias_m": 1.0, "bias_tau_s": 1.0}),), N, mismatch=Mismatch(gnss_slow=1.5))
    for _ in range(30):
        drive.sense()
    assert np.std(drive.measurements.fix_m) == pytest.approx(1.5, rel=TOLERANCE)


def test_a_camera_that_is_worse_states_and_trusts_what_its_data_sheet_says():
    figures = {"camera": {"white_m": 0.06, "bias_m": 0.03, "mount_m": 0.04, "trust_limit_m": 0.1}}
    stated, true = (measured(Mismatch(camera=factor), **figures) for factor in (1.0, 3.0))
    assert (true.camera_sigma_m == stated.camera_sigma_m).all()
    assert true.camera_valid.all()


def test_without_a_mismatch_every_figure_is_that_of_the_data_sheet():
    sensors = Sensors(tuple(one for one in PROFILES.values() if one.gnss.common_share is None), 0.1)
    assert len(sensors.profiles) == 5
    for stated, true in zip(sensors.stated, sensors.table, strict=True):
        np.testing.assert_array_equal(stated, true)
