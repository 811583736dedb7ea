"""What holds for every profile in the registry."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.sensors.profiles import residual_sigma_m
from gpsec.sensors.registry import PROFILES
from gpsec.types.vehicles import Measurements
from tests.sensors.exact import Drive

ALL = tuple(PROFILES.values())
N, STEPS = 24, 40


def snapshot(measurements: Measurements, rows=slice(None)) -> dict[str, np.ndarray]:
    return {name: array[rows].copy() for name, array in measurements._asdict().items()}


def move(drive: Drive, step: int) -> None:
    """Drive along a bend, in and out of junctions, a little different for each vehicle."""
    drive.move(8.0 + 0.1 * step, 0.05)
    index = np.arange(drive.count)
    drive.vehicles.lane_yaw_rad[:] = drive.vehicles.yaw_rad + 0.01 * np.cos(index)
    drive.vehicles.lane_offset_m[:] = 0.3 * np.sin(index + 0.2 * step)
    drive.vehicles.curvature_per_m[:] = 0.005
    drive.vehicles.marked[:] = (index + step) % 11 != 0


def record(profiles, count=N, rows=None, parts=None, threads=None, steps=STEPS):
    """Return the measurements of all steps, sensed in one batch or in `parts`."""
    drive = Drive(profiles, count)
    taken = []
    for step in range(steps):
        move(drive, step)
        if parts is None:
            drive.sense(rows, threads)
        else:
            for part in parts:
                drive.sense(np.asarray(part, np.int32))
                drive.step -= 1
            drive.step += 1
        taken.append(snapshot(drive.measurements))
    return taken


def assert_same(one, other):
    for left, right in zip(one, other, strict=True):
        for name, array in left.items():
            np.testing.assert_array_equal(array, right[name], err_msg=name)


@pytest.mark.parametrize("profile", ALL, ids=PROFILES)
def test_measurements_are_finite_and_of_the_right_kind(profile):
    for taken in record((profile,)):
        blank = Table(Measurements, N).now
        for name, array in taken.items():
            assert array.shape == getattr(blank, name).shape
            assert array.dtype == getattr(blank, name).dtype
            assert np.isfinite(array).all()
        assert (np.abs(taken["heading_rad"]) <= np.pi).all()
        seen = taken["camera_valid"]
        assert (taken["camera_sigma_m"][seen] <= profile.camera.trust_limit_m).all()
        assert (taken["camera_sigma_m"][seen] > 0.0).all()


@pytest.mark.parametrize("profile", ALL, ids=PROFILES)
def test_most_samples_arrive(profile):
    taken = record((profile,), count=200)
    share = min(profile.gnss.rate_hz / 10.0, 1.0)
    assert np.mean([t["fix_valid"] for t in taken]) == pytest.approx(share, abs=0.05)
    assert np.mean([t["camera_valid"] for t in taken]) > 0.8
    unmarked = [(np.arange(200) + step) % 11 == 0 for step in range(STEPS)]
    assert not np.any([t["camera_valid"] & u for t, u in zip(taken, unmarked, strict=True)])


@pytest.mark.parametrize("profile", ALL, ids=PROFILES)
def test_residual_on_a_straight_road_has_the_promised_sigma(profile):
    drive = Drive((profile,), 20_000)
    for _ in range(4):
        drive.move(15.0, 0.0)
        drive.sense()
    measured = drive.measurements
    both = measured.fix_valid & measured.camera_valid
    # The lane lies along the x axis: d_camera = -C0, and the map-matched offset of the fix is its y.
    residual = -measured.lane_poly[both, 0] - measured.fix_m[both, 1]
    assert np.std(residual) == pytest.approx(residual_sigma_m(profile), rel=0.05)


@pytest.mark.parametrize("profile", ALL, ids=PROFILES)
def test_same_seed_same_bytes(profile):
    assert_same(record((profile,)), record((profile,)))


def test_mixed_batch_is_the_loop_of_singles():
    assert_same(record(ALL), record(ALL, parts=[[row] for row in range(N)]))


def test_order_of_rows_does_not_matter():
    assert_same(record(ALL), record(ALL, rows=np.arange(N, dtype=np.int32)[::-1].copy()))


def test_threads_do_not_matter():
    threads = Threads(2)
    assert_same(record(ALL, 600, steps=10), record(ALL, 600, steps=10, threads=threads))
    threads.close()


def test_a_profile_does_not_depend_on_which_others_are_in_the_run():
    mixed = record(ALL)
    own = Drive((ALL[3],), N)
    own.vehicles.profile[:] = 0
    for step in range(STEPS):
        move(own, step)
        alone = snapshot(own.sense(), slice(3, None, 4))
        for name, array in alone.items():
            np.testing.assert_array_equal(array, mixed[step][name][3::4], err_msg=name)


def test_rows_that_are_not_sensed_are_left_alone():
    drive = Drive(ALL, N)
    drive.sense()
    before = snapshot(drive.measurements)
    move(drive, 0)
    drive.sense(np.asarray([1, 2], np.int32))
    after = snapshot(drive.measurements)
    for name, array in before.items():
        np.testing.assert_array_equal(array[3:], after[name][3:], err_msg=name)
    assert not np.array_equal(before["fix_m"][1:3], after["fix_m"][1:3])


def test_a_row_that_is_taken_again_knows_nothing_of_its_former_vehicle():
    used, new = Drive(ALL, N), Drive(ALL, N)
    used.vehicles.key[:] += np.uint64(1)
    used.sensors.enter(used.state, used.vehicles, used.rows, 0)
    for step in range(15):
        move(used, step)
        used.sense()
    used.vehicles.key[:] = new.vehicles.key
    new.step = used.step
    for drive in (used, new):
        drive.vehicles.rear_m[:] = 0.0
        drive.vehicles.yaw_rad[:] = 0.0
        drive.sensors.enter(drive.state, drive.vehicles, drive.rows, 15)
    for step in range(15, 30):
        for drive in (used, new):
            move(drive, step)
            drive.sense()
        assert_same([snapshot(used.measurements)], [snapshot(new.measurements)])


def test_rows_grow_without_changing_what_is_measured():
    small, large = Drive(ALL, 4), Drive(ALL, 4)
    for step in range(10):
        for drive in (small, large):
            move(drive, step)
        if step == 5:
            for table in large.tables:
                table.grow(64)
            large.count = 64
        small.sense()
        large.sense()
    assert_same([snapshot(small.measurements)], [snapshot(large.measurements, slice(4))])
