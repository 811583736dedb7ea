from dataclasses import dataclass, fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.fleet import Measurements, Rows, Slots, Tracks, Vehicles


@dataclass
class Pair(Rows):
    flag: np.ndarray
    matrix: np.ndarray

    @classmethod
    def empty(cls, capacity: int) -> "Pair":
        return cls(np.ones(capacity, np.bool_), np.full((capacity, 2, 2), 7.0))


def rows(*numbers: int) -> np.ndarray:
    return np.array(numbers, np.int32)


def test_new_rows_hold_initial_values_and_old_ones_theirs():
    pair = Pair.empty(1)
    pair.matrix[0] = 1.0
    pair.flag[0] = False
    pair.grow(3)
    assert pair.capacity == 3
    assert pair.flag.tolist() == [False, True, True]
    assert pair.matrix[:, 0, 1].tolist() == [1.0, 7.0, 7.0]
    pair.grow(2)
    assert pair.capacity == 3


def test_reset_gives_the_values_of_creation_even_where_row_0_has_changed():
    pair = Pair.empty(3)
    pair.matrix[:] = [[[0.0]], [[1.0]], [[2.0]]]
    pair.flag[:] = False
    pair.reset(rows(2))
    assert pair.matrix[:, 1, 0].tolist() == [0.0, 1.0, 7.0]
    assert pair.flag.tolist() == [False, False, True]


def test_copy_is_pair_by_pair_and_deep():
    pair = Pair.empty(4)
    pair.matrix[:] = np.arange(4.0)[:, None, None]
    pair.copy(rows(0, 0, 1), rows(2, 3, 0))
    assert pair.matrix[:, 0, 0].tolist() == [1.0, 1.0, 0.0, 0.0]
    pair.matrix[0] = 9.0
    assert pair.matrix[2, 0, 0] == 0.0


@pytest.mark.parametrize("kind", [Vehicles, Measurements, Tracks])
def test_every_field_has_the_row_as_first_axis_and_grows_like_a_bigger_one(kind):
    small, big = kind.empty(1), kind.empty(5)
    small.grow(5)
    for field in fields(kind):
        one, other = getattr(small, field.name), getattr(big, field.name)
        assert one.shape == other.shape
        assert len(one) == 5
        assert (one.dtype, one.tobytes()) == (other.dtype, other.tobytes())


@given(st.lists(st.one_of(st.none(), st.integers(0, 30)), max_size=80))
def test_slots_hand_out_the_lowest_free_row(orders):
    """None takes a row, a number gives back that of the rows in use."""
    slots, taken, highest = Slots(), set(), 0
    for order in orders:
        if order is None:
            row = slots.take()
            assert row == next(number for number in range(len(taken) + 1) if number not in taken)
            taken.add(row)
        elif taken:
            row = sorted(taken)[order % len(taken)]
            slots.give_back(row)
            taken.remove(row)
        highest = max(highest, len(taken))
        assert all(row < slots.used for row in taken)
    assert slots.used == highest
