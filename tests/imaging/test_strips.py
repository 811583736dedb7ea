"""Strips: what is near, and what is drawn in one piece."""

import numpy as np

from gpsec.core.tables import taken
from gpsec.imaging.pictures.strips import Painted, join_strips, runs


def strips_of(count):
    draw = np.random.default_rng(1)
    ends = [draw.uniform(-200.0, 300.0, (4, 2)) for _ in range(count)]
    return join_strips([(end, end + 1.0, number % 3, np.zeros(4)) for number, end in enumerate(ends)])


def test_all_that_is_near_is_found_in_order():
    strips = strips_of(200)
    ground, place = Painted.of(strips), np.array([37.0, -12.0])
    near = ground.near(place, 60.0)
    inside = taken(strips, (np.abs(strips.left_m - place) <= 60.0).all(axis=1))
    found = {tuple(point) for point in near.left_m.tolist()}
    assert {tuple(point) for point in inside.left_m.tolist()} <= found
    assert (np.diff(near.strip) >= 0).all()
    assert len(near.strip) < len(strips.strip)


def test_nothing_is_near_far_away():
    assert len(Painted.of(strips_of(5)).near(np.array([1e6, 1e6]), 50.0).strip) == 0


def test_runs_end_with_their_strip_and_where_one_sees_no_further():
    line = np.zeros((4, 2))
    strips = join_strips([(line, line, 0, np.zeros(4))] * 2)
    shown = np.array([True, True, True, True, True, True, False, True])
    assert runs(strips, shown, np.zeros(8, np.int32)) == [slice(0, 4), slice(4, 6)]


def test_a_new_level_begins_at_the_last_cross_section_of_the_old_one():
    line = np.zeros((5, 2))
    strips = join_strips([(line, line, 0, np.zeros(5))])
    assert runs(strips, np.ones(5, np.bool_), np.array([2, 2, 2, 7, 7], np.int32)) == [slice(0, 3), slice(2, 5)]
