"""The memory of honest fixes, against a plain list."""

import numpy as np
import pytest

from gpsec.attacks.knowledge import new_history, past_fixes, record_fixes

ALL = np.arange(3, dtype=np.int32)


def test_it_gives_what_a_list_would_give() -> None:
    rng = np.random.default_rng(2)
    fixes, valid = rng.normal(size=(40, 3, 2)), rng.random((40, 3)) < 0.5
    table = new_history(3, memory_s=0.7, step_s=0.1)
    for step in range(40):
        record_fixes(ALL, step, fixes[step], valid[step], table.now)
        read = past_fixes(table.now, ALL, step, 0.1)
        for delay in range(8):
            past_m, exists = read(delay * 0.1)
            for row in range(3):
                earlier = [k for k in range(step - delay + 1) if valid[k, row]]
                assert exists[row] == bool(earlier)
                if earlier:
                    assert np.array_equal(past_m[row], fixes[earlier[-1], row])


def test_a_delay_between_two_steps_gives_the_older_fix() -> None:
    table = new_history(3, memory_s=0.25, step_s=0.1)
    for step in range(5):
        record_fixes(ALL, step, np.full((3, 2), float(step)), np.ones(3, np.bool_), table.now)
    past_m, _ = past_fixes(table.now, ALL[:1], 4, 0.1)(0.25)
    assert past_m.tolist() == [[1.0, 1.0]]


def test_asking_for_more_than_it_holds_is_a_mistake() -> None:
    read = past_fixes(new_history(3, memory_s=1.0, step_s=0.1).now, ALL, 50, 0.1)
    read(1.0)
    with pytest.raises(ValueError, match=r"1\.2 s ago was asked for, but the memory is 1 s long"):
        read(1.2)


def test_a_new_vehicle_in_the_row_has_no_past() -> None:
    table = new_history(3, memory_s=0.5, step_s=0.1)
    yes = np.ones(3, np.bool_)
    for step in range(10):
        record_fixes(ALL, step, np.full((3, 2), 7.0), yes, table.now)
    table.reset(np.array([1], np.int32))
    record_fixes(ALL, 10, np.full((3, 2), 8.0), yes, table.now)
    past_m, exists = past_fixes(table.now, ALL, 10, 0.1)(0.1)
    assert exists.tolist() == [True, False, True]
    assert past_m[0].tolist() == [7.0, 7.0]
    assert past_fixes(table.now, ALL, 10, 0.1)(0.0)[0].tolist() == [[8.0, 8.0]] * 3


def test_it_grows_with_the_fleet() -> None:
    table = new_history(3, memory_s=0.5, step_s=0.1)
    record_fixes(ALL, 0, np.full((3, 2), 7.0), np.ones(3, np.bool_), table.now)
    table.grow(5)
    more = np.arange(5, dtype=np.int32)
    record_fixes(more, 1, np.full((5, 2), 8.0), np.ones(5, np.bool_), table.now)
    _, exists = past_fixes(table.now, more, 1, 0.1)(0.1)
    assert exists.tolist() == [True, True, True, False, False]
