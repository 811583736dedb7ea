from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.core.tables import Slots, Table, blank, concatenated, taken
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class Pair(NamedTuple):
    flag: np.ndarray = blank(True)
    matrix: np.ndarray = blank(7.0, "side", 2)
    number: np.ndarray = blank(-1)
    key: np.ndarray = blank(np.uint64(0))


def pairs(capacity: int) -> Table[Pair]:
    return Table(Pair, capacity, side=2)


def rows(*numbers: int) -> np.ndarray:
    return np.array(numbers, np.int32)


class Both(NamedTuple):
    pair: Pair = Pair()
    own: np.ndarray = blank(3.0)


def test_a_field_has_the_type_and_the_shape_that_is_declared():
    pair = pairs(3).now
    assert [array.dtype for array in pair] == [np.bool_, np.float64, np.int32, np.uint64]
    assert [array.shape for array in pair] == [(3,), (3, 2, 2), (3,), (3,)]


def test_a_length_that_is_not_given_is_named():
    with pytest.raises(KeyError, match="side"):
        Table(Pair)


def test_new_rows_are_fresh_and_old_ones_keep_their_values():
    table = pairs(1)
    table.now.matrix[0] = 1.0
    table.now.flag[0] = False
    table.grow(3)
    assert table.capacity == 3
    assert table.now.flag.tolist() == [False, True, True]
    assert table.now.matrix[:, 0, 1].tolist() == [1.0, 7.0, 7.0]
    table.grow(2)
    assert table.capacity == 3


def test_a_row_that_is_reset_is_fresh_even_where_row_0_has_changed():
    table = pairs(3)
    table.now.matrix[:] = [[[0.0]], [[1.0]], [[2.0]]]
    table.now.flag[:] = False
    table.reset(rows(2))
    assert table.now.matrix[:, 1, 0].tolist() == [0.0, 1.0, 7.0]
    assert table.now.flag.tolist() == [False, False, True]


def test_copy_is_pair_by_pair_and_deep():
    table = pairs(4)
    table.now.matrix[:] = np.arange(4.0)[:, None, None]
    table.copy(rows(0, 0, 1), rows(2, 3, 0))
    assert table.now.matrix[:, 0, 0].tolist() == [1.0, 1.0, 0.0, 0.0]
    table.now.matrix[0] = 9.0
    assert table.now.matrix[2, 0, 0] == 0.0


def test_a_structure_in_a_structure_is_part_of_its_rows():
    table = Table(Both, 1, side=2)
    table.now.pair.matrix[0], table.now.own[0] = 1.0, 1.0
    table.grow(3)
    table.copy(rows(0), rows(2))
    assert table.now.pair.matrix[:, 1, 0].tolist() == [1.0, 7.0, 1.0]
    assert table.now.own.tolist() == [1.0, 3.0, 1.0]
    assert table.now.pair.number.tolist() == [-1, -1, -1]
    table.reset(rows(0))
    assert table.now.pair.matrix[:, 1, 0].tolist() == [7.0, 7.0, 1.0]
    assert table.now.own.tolist() == [3.0, 3.0, 1.0]


@pytest.mark.parametrize("structure", [Vehicles, Measurements, Tracks, Answers])
def test_a_table_that_has_grown_is_like_one_that_was_made_bigger(structure):
    lengths = {"detectors": 2, "defences": 3}
    small, big = Table(structure, 1, **lengths), Table(structure, 5, **lengths)
    small.grow(5)
    for one, other in zip(small.now, big.now, strict=True):
        assert one.shape == other.shape
        assert len(one) == 5
        assert (one.dtype, one.tobytes()) == (other.dtype, other.tobytes())


def test_rows_are_taken_and_put_together_in_structures_of_structures():
    one, two = Table(Both, 3, side=1).now, Table(Both, 1, side=1).now
    one.own[:], one.pair.number[:], two.pair.number[:] = [1.0, 2.0, 3.0], [4, 5, 6], [9]
    some, other = taken(one, rows(2, 0)), taken(one, np.array([False, True, False]))
    assert (some.own.tolist(), some.pair.number.tolist(), other.own.tolist()) == ([3.0, 1.0], [6, 4], [2.0])
    some.own[:] = 0.0
    assert one.own.tolist() == [1.0, 2.0, 3.0]
    assert concatenated([some, two, other]).pair.number.tolist() == [6, 4, 9, 5]


@given(st.lists(st.one_of(st.none(), st.integers(0, 30)), max_size=80))
def test_slots_hand_out_the_lowest_free_row(orders):
    """None takes a row, a number gives back that of the rows in use."""
    slots, in_use, highest = Slots(), set(), 0
    for order in orders:
        if order is None:
            row = slots.take()
            assert row == next(number for number in range(len(in_use) + 1) if number not in in_use)
            in_use.add(row)
        elif in_use:
            row = sorted(in_use)[order % len(in_use)]
            slots.give_back(row)
            in_use.remove(row)
        highest = max(highest, len(in_use))
        assert all(row < slots.used for row in in_use)
    assert slots.used == highest
