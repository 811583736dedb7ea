"""The monitor on one vehicle that drives east in the middle of its lane, with sensors without noise."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.evidence import is_contradicted, weigh
from gpsec.detection.monitor import Monitor
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Pending
from gpsec.filters.noise import noise_table
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES, rig_figures
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

ONE, GATE = np.zeros(1, np.int32), 41.0


class Ride:
    """One vehicle and its monitor."""

    def __init__(self, figures=RIG_FIGURES, preset="R2", speed_mps=10.0) -> None:
        self.monitor = Monitor(MonitorRules(STEP_S, noise_table([figures]), np.array([GATE]), *PRESETS[preset]))
        self.tracks, self.truth, self.seen, self.pending = (
            Table(kind).now for kind in (Tracks, Vehicles, Measurements, Pending)
        )
        self.tracks.vehicle[:], self.tracks.lane_known[:] = 0, True
        self.seen.speed_mps[:] = speed_mps
        self.pending.sigma_m[:] = 0.08
        self.place_m = np.zeros(2)
        self.number = 0

    @property
    def now(self):
        return self.monitor.now

    def step(self, off_m=(0.0, 0.0), fix=True, camera=True, residual_m=None, rate_rps=0.0, matched=True):
        """Take a step with a fix that is off, and return what the monitor says."""
        self.place_m[0] += self.seen.speed_mps[0] * STEP_S
        self.tracks.fix_m[:], self.tracks.fix_valid[:] = self.place_m + off_m, fix
        self.tracks.residual_valid[:], self.tracks.unmatched[:] = fix and camera and matched, not matched
        self.tracks.residual_m[:] = -off_m[1] if residual_m is None else residual_m
        self.seen.camera_valid[:], self.seen.yaw_rate_rps[:] = camera, rate_rps
        told = self.monitor.update(self.number, self.pending, ONE, self.tracks, self.truth, self.seen, Threads(1))
        self.number += 1
        return told

    def steps(self, count, **step):
        return [float(self.step(**step).joint[0]) for _ in range(count)]

    @property
    def error_m(self):
        """Estimate minus truth."""
        return self.now.mean[0, :2] - self.place_m


def test_evidence_is_the_sum_of_samples_over_the_root_of_their_number():
    sums, there = np.zeros((3, 4, 4)), np.array([True, True, False, False])
    for _ in range(3):
        joint, innovation = weigh(sums, np.array([2.0, 0.0, 9.0, 0.0]), there, False)
    # λ = 0.95: A = 2(1 + 0.95 + 0.9025), N = 1 + 0.9025 + 0.81450625; the other scales have less.
    assert joint == pytest.approx(5.705**2 / 2.71700625, rel=1e-12)
    assert innovation == joint
    # A mean of 2, and a sample of 0: 2·0 - 2 is more than -3; with a sample of -1 it is -4.
    assert not is_contradicted(sums, np.array([0.0, 0.0, 0.0, 0.0]), there)
    assert is_contradicted(sums, np.array([-1.0, 0.0, 0.0, 0.0]), there)


def test_samples_that_stand_alone_leave_the_longer_scales():
    sums, there = np.zeros((3, 4, 4)), np.array([True, True, True, False])
    weigh(sums, np.array([3.0, 0.0, 0.0, 0.0]), there, False)
    before = sums[:, 1:].copy()
    joint, innovation = weigh(sums, np.array([1.0, 2.0, 2.0, 0.0]), there, True)
    assert (joint, innovation) == (9.0, 5.0)
    assert (sums[:, 1:] == before).all()


@pytest.mark.parametrize("off_m", [(0.0, 2.4), (5.0, 0.0), (-5.0, -2.4)])
def test_a_jump_is_seen_at_once_kept_out_and_over_with_the_first_honest_fix(off_m):
    ride = Ride()
    assert max(ride.steps(100)) < 1.0
    assert min(ride.steps(100, off_m=off_m)) > GATE
    assert np.abs(ride.error_m).max() < 0.05
    # The filter has coasted for 10 s, so that the first honest fix is not quite where it is expected.
    assert max(ride.steps(50)) < 9.0
    assert not ride.now.alarm[0]


def test_the_camera_alone_raises_the_joint_statistic_and_not_that_of_the_innovations():
    ride = Ride()
    ride.steps(100)
    # Each counts for three deviations at most, since a camera has tails, and the slow part follows as far as it may.
    told = ride.step(residual_m=1.5)
    assert told.joint[0] == pytest.approx(9.0, abs=0.1)
    for _ in range(9):
        told = ride.step(residual_m=1.5)
    assert told.joint[0] > GATE
    assert told.innovation[0] < 1.0
    assert (told.along[0], told.across[0]) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_lane_that_the_map_has_not_raises_an_alarm_and_ends_it():
    ride = Ride()
    ride.steps(100)
    # Each counts for three deviations: four of them, at λ = 0.95, are (3 · 3.7099)² / 3.4517 = 35.9.
    told = ride.steps(6, matched=False)
    assert told[3] == pytest.approx(35.9, rel=0.05)
    assert told[5] > GATE
    assert ride.step(matched=False).innovation[0] < 1.0
    assert max(ride.steps(5)) < 9.0


def test_a_vehicle_that_stands_keeps_its_yaw_and_learns_the_bias_of_its_gyro():
    figures = rig_figures(gyro_bias_rps=1e-3, gyro_bias_tau_s=1e6)
    ride = Ride(figures, speed_mps=0.0)
    for _ in range(600):
        ride.step(rate_rps=8e-4)
    assert ride.now.mean[0, 6] == pytest.approx(8e-4, rel=0.01)
    assert ride.now.mean[0, 2] == pytest.approx(0.0, abs=1e-6)
    # Fixes of a vehicle that stands say nothing of its yaw.
    assert ride.now.covariance[0, 2, 2] <= figures.heading_rad**2


def test_a_vehicle_that_creeps_round_a_bend_learns_no_bias():
    ride = Ride(speed_mps=0.05)
    for _ in range(50):
        ride.step(rate_rps=0.02)
    assert abs(ride.now.mean[0, 6]) < RIG_FIGURES.gyro_bias_rps
    assert ride.now.mean[0, 2] == pytest.approx(0.02 * 49 * STEP_S, rel=0.1)


def test_fixes_are_not_used_while_the_camera_is_blind_but_each_is_tested():
    seeing, blind = Ride(), Ride()
    for ride in (seeing, blind):
        ride.steps(300)
    blind.steps(4, camera=False)
    before = blind.now.covariance[0, 0, 0]
    for _ in range(10):
        seeing.step(off_m=(0.3, 0.0))
        told = blind.step(off_m=(0.3, 0.0), camera=False)
    assert told.blind[0]
    assert told.tested[0]
    assert told.joint[0] == pytest.approx(told.along[0] ** 2 + told.across[0] ** 2)
    assert told.along[0] > 1.0
    assert blind.error_m[0] == pytest.approx(0.0, abs=1e-6)
    assert seeing.error_m[0] > 0.01
    assert blind.now.covariance[0, 0, 0] > before
    blind.steps(95, camera=False)
    assert not blind.step(camera=False).blind[0]


@pytest.mark.parametrize(("preset", "cap"), [("R2", 2.5), ("R3", 3.0)])
def test_it_learns_how_noisy_fixes_are_up_to_its_cap(preset, cap):
    rng = np.random.default_rng(3)
    for factor, low, high in ((1.0, 0.8, 1.3), (1.4, 1.6, 2.4), (3.0, 0.99 * cap, 1.001 * cap)):
        ride = Ride(preset=preset)
        learnt = []
        for n in range(2500):
            ride.step(off_m=rng.normal(0.0, factor * RIG_FIGURES.gnss_white_m, 2), residual_m=0.0)
            learnt += [np.exp(ride.now.gnss[0])] * (n > 1000)
        assert low < np.median(learnt) <= high


def test_what_was_absorbed_is_given_back_when_the_camera_and_fixes_agree_again():
    ride = Ride()
    ride.steps(200)
    # The vehicle itself slips by 0.9 m, as on ice: fixes and camera agree, odometer and gyro do not.
    ride.place_m[1] += 0.9
    told = ride.steps(1, residual_m=0.0)
    assert told[0] > GATE
    later = ride.steps(30, residual_m=0.0)
    assert max(later[:8]) > GATE
    assert max(later[12:]) < 9.0
    assert abs(ride.error_m[1]) < 0.2


def test_statistics_are_not_of_fixes_that_come_faster_than_detectors_look():
    ride = Ride()
    fast = Monitor(MonitorRules(0.025, noise_table([RIG_FIGURES]), np.array([GATE]), *PRESETS["R2"]))
    tested = [
        bool(fast.update(n, ride.pending, ONE, _fixed(ride), ride.truth, ride.seen, Threads(1)).tested[0])
        for n in range(41)
    ]
    assert sum(tested) == 10


def _fixed(ride):
    ride.tracks.fix_valid[:] = True
    ride.seen.speed_mps[:] = 0.0
    return ride.tracks
