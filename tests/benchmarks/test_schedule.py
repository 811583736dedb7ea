"""The simulated schedule deals out tasks as workers take them."""

import pytest

from benchmarks.schedule import makespan_s


def test_whoever_is_free_takes_the_next() -> None:
    # Two workers: 3 | 1, 1, 1 and then 2 on the first that is free, at 3 s.
    assert makespan_s([3.0, 1.0, 1.0, 1.0, 2.0], 2, 0.0, 0.0) == 5.0
    assert makespan_s([3.0, 1.0, 1.0, 1.0, 2.0], 1, 0.5, 0.0) == 10.5


def test_who_deals_out_is_the_bound_in_the_end() -> None:
    times_s = [1.0] * 100
    assert makespan_s(times_s, 100, 0.0, 0.0) == 1.0
    assert makespan_s(times_s, 100, 0.0, 0.01) == pytest.approx(2.0)
