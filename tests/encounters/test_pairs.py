"""Contacts of rectangles, against shapely and by hand."""

import numpy as np
import pytest
import shapely

from gpsec.core.kernels import kernel
from gpsec.encounters.meeting import Kind, directions, needed_braking
from gpsec.encounters.pairs import close_pairs
from gpsec.encounters.rectangles import meeting
from gpsec.reference.encounters import outline, overlapping, seconds_to_contact

from .scene import bodies, random_bodies


@kernel
def _meet(bodies_, first, second, gap, contact):
    for k in range(len(first)):
        gap[k], contact[k] = meeting(bodies_, first[k], second[k])


def test_100_000_random_rectangle_pairs_overlap_where_shapely_says_so():
    count = 100_000
    scene = random_bodies(2 * count, 6.0)
    first, second = np.arange(count, dtype=np.int32), np.arange(count, 2 * count, dtype=np.int32)
    gap, contact = np.zeros(count), np.zeros(count)
    _meet(scene, first, second, gap, contact)
    shapes = np.array([outline(scene, i) for i in range(2 * count)])
    expected = shapely.intersects(shapes[:count], shapes[count:])
    clear = np.abs(gap) >= 1e-9
    np.testing.assert_array_equal(gap[clear] < 0.0, expected[clear])
    assert clear.sum() > 0.999 * count
    assert 0.1 < expected.mean() < 0.9
    np.testing.assert_array_equal(contact == 0.0, gap < 0.0)


def test_the_grid_finds_every_pair_that_overlaps():
    scene = random_bodies(400, 150.0)
    found = close_pairs(scene)
    touching = {(i, j) for i, j, gap in zip(found.first, found.second, found.gap_m, strict=True) if gap < 0.0}
    assert touching == {(int(i), int(j)) for i, j in np.argwhere(overlapping(scene)) if i > j}
    assert len(touching) > 20


def test_times_to_contact_are_those_of_the_minkowski_sum():
    scene = random_bodies(60, 29.0, seed=2)
    found = close_pairs(scene, 4.0)
    times = dict(zip(zip(found.first.tolist(), found.second.tolist(), strict=True), found.contact_s, strict=True))
    later = 0
    for i in range(60):
        for j in range(i):
            expected = seconds_to_contact(scene, i, j)
            if abs(expected - 4.0) < 1e-6:
                continue
            assert ((i, j) in times) == (expected < 4.0)
            if expected < 4.0:
                assert times[i, j] == pytest.approx(expected, abs=1e-6)
                later += expected > 0.0
    assert later > 100


def test_more_pairs_than_there_is_room_for_at_first():
    scene = bodies(*[(0.1 * k, 0.0, 0.0, 0.0) for k in range(20)])
    assert len(close_pairs(scene).first) == 190


def test_nobody_and_one_alone_meet_nobody():
    assert len(close_pairs(bodies((0.0, 0.0, 0.0, 9.0))).first) == 0


def test_a_follower_and_an_oncoming_car_by_hand():
    """A gap of 16 m at 8 m/s of difference is 2 s, and takes 8/(2·2) = 2 m/s²."""
    scene = bodies((0.0, 0.0, 0.0, 20.0), (20.0, 0.5, 0.0, 12.0), (-20.0, 3.5, 0.0, 20.0), (80.0, 3.6, 180.0, 20.0))
    found = close_pairs(scene)
    pairs = dict(zip(zip(found.first.tolist(), found.second.tolist(), strict=True), range(9), strict=False))
    assert set(pairs) == {(1, 0), (3, 2)}
    at = pairs[1, 0]
    assert found.gap_m[at] == pytest.approx(16.0)
    assert found.contact_s[at] == pytest.approx(2.0)
    assert needed_braking(found)[at] == pytest.approx(2.0)
    assert directions(scene, found)[at] == Kind.SAME
    at = pairs[3, 2]
    assert found.contact_s[at] == pytest.approx(96.0 / 40.0)
    assert found.closing_mps[at] == pytest.approx(40.0)
    assert directions(scene, found)[at] == Kind.ONCOMING


def test_cars_that_cross_and_cars_that_pass_each_other():
    scene = bodies((0.0, 0.0, 0.0, 10.0), (20.0, -20.0, 90.0, 10.0), (100.0, 0.0, 0.0, 10.0), (140.0, 2.1, 180.0, 10.0))
    found = close_pairs(scene)
    assert list(zip(found.first.tolist(), found.second.tolist(), strict=True)) == [(1, 0)]
    assert found.contact_s[0] == pytest.approx((20.0 - 3.0) / 10.0)
    assert directions(scene, found)[0] == Kind.CROSSING
