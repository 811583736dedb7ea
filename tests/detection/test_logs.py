from dataclasses import replace

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.detection.logs import Grid, sessions, split
from gpsec.testing.residuals import make_log


def test_grid_aligns_vehicles_at_their_first_step_and_fills_missing_steps():
    log = make_log(2, 6, seed=1, gaps=False)
    # Vehicle 0: steps 7, 8, 10; vehicle 1: steps 2 … 6.
    keep = np.asarray([True, True, False, True, False, False, *[True] * 5, False])
    log = replace(log, step=log.step + np.repeat(np.asarray([7, 2], np.int32), 6)).select(keep)
    grid = Grid.of([log])
    assert grid.length.tolist() == [5, 4]
    assert grid.valid.T.tolist() == [[True] * 5, [True, True, False, True, False]]
    assert grid.residual_m[:, 0].tolist() == log.residual_m[3:].tolist()
    assert grid.residual_m[[0, 1, 3], 1].tolist() == log.residual_m[:3].tolist()
    assert [grid.active(t) for t in range(5)] == [2, 2, 2, 2, 1]
    assert [v for v, _ in sessions(grid, gap_steps=1)] == [0, 1, 1]


def test_select_keeps_the_chosen_vehicles():
    grid = Grid.of([make_log(3, 5, seed=1)])
    chosen = grid.select(np.asarray([True, False, True]))
    assert chosen.length.tolist() == [5, 5]
    assert chosen.residual_m.tolist() == grid.residual_m[:, [0, 2]].tolist()
    nobody = grid.select(np.zeros(3, np.bool_))
    assert (len(nobody.length), len(nobody.valid)) == (0, 0)


def test_split_parts_vehicles_and_is_repeatable():
    logs = [make_log(100, 5, seed=1)]
    (first,), (second,) = split(logs, 0.3, seed=4)
    assert set(first.vehicle).isdisjoint(second.vehicle)
    assert len(set(first.vehicle)) + len(set(second.vehicle)) == 100
    assert 15 < len(set(first.vehicle)) < 45
    assert np.array_equal(split(logs, 0.3, seed=4)[0][0].vehicle, first.vehicle)
    assert not np.array_equal(split(logs, 0.3, seed=5)[0][0].vehicle, first.vehicle)


def test_logs_that_do_not_belong_together_are_refused():
    with pytest.raises(GpsecError, match="one profile"):
        Grid.of([make_log(2, 5), replace(make_log(2, 5), profile="dsd")])
    log = make_log(2, 5)
    with pytest.raises(GpsecError, match="sorted"):
        Grid.of([log.select(np.arange(len(log.vehicle))[::-1])])


def test_steps_since_the_last_residual_are_counted():
    grid = Grid.of([make_log(1, 7, gaps=False)])
    grid.valid[:, 0] = [False, True, True, False, False, True, True]
    assert [int(grid.observe(step).elapsed_steps[0]) for step in range(7)] == [1, 2, 1, 1, 2, 3, 1]
