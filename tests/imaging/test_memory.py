"""What was seen, moved on with the vehicle."""

from dataclasses import replace

import numpy as np
import pytest

from gpsec.imaging.pictures.lanes import NO_LANE, SeenLane
from gpsec.imaging.pictures.memory import LaneMemory, moved_on


def test_a_lane_is_moved_on_as_the_vehicle_moves():
    poly = np.array([0.5, 0.02, 1e-3, -1e-5])
    moved = moved_on(poly, 2.0, 0.0)
    for x in (0.0, 5.0, 20.0):
        there = np.polynomial.polynomial.polyval(x + 2.0, poly)
        assert np.polynomial.polynomial.polyval(x, moved) == pytest.approx(there)
    assert moved_on(poly, 0.0, 0.03)[1] == pytest.approx(0.02 - 0.03)


def seen(c0):
    return SeenLane(np.array([c0, 0.0, 0.0, 0.0]), 3.5, 0.1, True)


def test_noise_is_averaged_over_the_way():
    draw = np.random.default_rng(4)
    memory = LaneMemory(15.0)
    kept = [memory.take(seen(draw.normal(0.0, 0.1)), (1.0, 0.0)).poly[0] for _ in range(2000)]
    share = 1.0 - np.exp(-1.0 / 15.0)  # σ² share / (2 - share) for white noise
    assert np.std(kept[100:]) == pytest.approx(0.1 * np.sqrt(share / (2.0 - share)), rel=0.15)


def test_in_a_sharp_bend_less_is_remembered():
    """How a lane goes on there, no polynomial says for long."""
    kept = {}
    for bends in (False, True):
        memory = LaneMemory(15.0)
        for _ in range(30):
            memory.take(seen(0.0), (1.0, 0.0))
        kept[bends] = memory.take(replace(seen(0.3), bends=bends), (1.0, 0.0)).poly[0]
    assert kept[False] == pytest.approx(0.3 * (1.0 - np.exp(-1.0 / 15.0)))
    assert kept[True] == pytest.approx(0.3 * (1.0 - np.exp(-1.0 / 3.0)))


def test_nothing_stays_nothing_and_a_jump_is_the_next_lane():
    memory = LaneMemory()
    memory.take(seen(-1.7), None)
    assert not memory.take(NO_LANE, (1.0, 0.0)).valid
    assert memory.take(seen(1.7), (1.0, 0.0)).poly[0] == 1.7


def test_after_a_gap_it_begins_anew():
    memory = LaneMemory()
    memory.take(seen(0.0), None)
    assert memory.take(seen(0.4), None).poly[0] == 0.4
    memory.take(NO_LANE, (20.0, 0.0))
    assert memory.take(seen(0.2), (1.0, 0.0)).poly[0] == 0.2
