"""What holds for every profile in the registry; the rules are in `gpsec.testing`, those of a mixed fleet here."""

import numpy as np
import pytest

from gpsec.core.threads import Threads
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.registry import PROFILES
from gpsec.testing import PROFILE_CHECKS, BrokenContractError, check_profile
from gpsec.testing.drive import Drive
from gpsec.testing.profiles import STEPS, VEHICLES, along_a_bend, record, same, snapshot
from tests.sensors.exact import profile

ALL = tuple(PROFILES.values())


@pytest.mark.parametrize("check", PROFILE_CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("profile", ALL, ids=PROFILES)
def test_it_keeps_the_contract(profile: SensorProfile, check) -> None:
    check(profile)


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"title": "two\nlines"}, "the title is one line"),
        ({"sources": {"map_spacing_m": "me"}}, "says where the figure comes from"),
        ({"camera": profile(camera={"trust_limit_m": 1e-9, "white_m": 0.1}).camera}, "a lane is seen on at least half"),
    ],
)
def test_a_profile_that_breaks_a_rule_is_told_which(changes, rule) -> None:
    with pytest.raises(BrokenContractError, match=rule):
        check_profile(PROFILES["carla"].model_copy(update=changes))


def test_mixed_batch_is_the_loop_of_singles():
    assert same(record(ALL), record(ALL, parts=[[row] for row in range(VEHICLES)]))


def test_order_of_rows_does_not_matter():
    assert same(record(ALL), record(ALL, parts=[range(VEHICLES)[::-1]]))


def test_threads_do_not_matter():
    threads = Threads(2)
    assert same(record(ALL, 600, steps=10), record(ALL, 600, steps=10, threads=threads))
    threads.close()


def test_a_profile_does_not_depend_on_which_others_are_in_the_run():
    mixed = record(ALL)
    own = Drive((ALL[3],), VEHICLES)
    own.vehicles.profile[:] = 0
    for step in range(STEPS):
        along_a_bend(own, step)
        alone = snapshot(own.sense(), slice(3, None, len(ALL)))
        for name, array in alone.items():
            np.testing.assert_array_equal(array, mixed[step][name][3 :: len(ALL)], err_msg=name)


def test_rows_that_are_not_sensed_are_left_alone():
    drive = Drive(ALL, VEHICLES)
    drive.sense()
    before = snapshot(drive.measurements)
    along_a_bend(drive, 0)
    drive.sense(np.asarray([1, 2], np.int32))
    after = snapshot(drive.measurements)
    for name, array in before.items():
        np.testing.assert_array_equal(array[3:], after[name][3:], err_msg=name)
    assert not np.array_equal(before["fix_m"][1:3], after["fix_m"][1:3])


def test_a_row_that_is_taken_again_knows_nothing_of_its_former_vehicle():
    used, new = Drive(ALL, VEHICLES), Drive(ALL, VEHICLES)
    used.vehicles.key[:] += np.uint64(1)
    used.sensors.enter(used.state, used.vehicles, used.rows, 0)
    for step in range(15):
        along_a_bend(used, step)
        used.sense()
    used.vehicles.key[:] = new.vehicles.key
    new.step = used.step
    for drive in (used, new):
        drive.vehicles.rear_m[:] = 0.0
        drive.vehicles.yaw_rad[:] = 0.0
        drive.sensors.enter(drive.state, drive.vehicles, drive.rows, 15)
    for step in range(15, 30):
        for drive in (used, new):
            along_a_bend(drive, step)
            drive.sense()
        assert same([snapshot(used.measurements)], [snapshot(new.measurements)])


def test_rows_grow_without_changing_what_is_measured():
    small, large = Drive(ALL, 4), Drive(ALL, 4)
    for step in range(10):
        for drive in (small, large):
            along_a_bend(drive, step)
        if step == 5:
            for table in large.tables:
                table.grow(64)
            large.count = 64
        small.sense()
        large.sense()
    assert same([snapshot(small.measurements)], [snapshot(large.measurements, slice(4))])
