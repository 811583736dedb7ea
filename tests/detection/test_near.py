import numpy as np
import pytest

from gpsec.detection.logs import Grid
from gpsec.detection.near import NearVehicles, level_of
from gpsec.testing.residuals import make_log


def test_the_level_is_what_as_many_exceed_as_are_kept():
    peaks = np.arange(2000.0)
    assert (peaks > level_of(peaks, 1000.0)).sum() == 500
    # Of few hours thirty are kept, where there are so many.
    assert (peaks > level_of(peaks, 10.0)).sum() == 30
    assert (peaks[:20] > level_of(peaks[:20], 10.0)).sum() == 19
    assert level_of(np.zeros(0), 1.0) == 0.0


def test_vehicles_below_a_level_that_has_risen_are_dropped():
    near = NearVehicles()
    for seed in (1, 2):
        near.take(
            Grid.of([make_log(4, 50, seed=seed)]), np.array([[1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 9.0]]), [2.0, 5.0]
        )
    assert [len(grid.length) for grid in near.grids] == [2, 2]
    near.take(Grid.of([make_log(1, 50, seed=3)]), np.array([[0.0], [0.0]]), [10.0, 5.0])
    assert [len(grid.length) for grid in near.grids] == [1, 1, 0]


@pytest.mark.parametrize("together", [1, 3, 100])
def test_groups_have_every_vehicle_once_the_longest_first(together, monkeypatch):
    monkeypatch.setattr("gpsec.detection.near._TOGETHER", together)
    grids = [Grid.of([make_log(3, steps, seed=steps)]) for steps in (40, 70, 55)]
    near = NearVehicles()
    for grid in grids:
        near.take(grid, np.ones((1, 3)), [0.0])
    groups = list(near.groups())
    assert all(len(group.length) <= together for group in groups)
    assert np.concatenate([group.length for group in groups]).tolist() == [70] * 3 + [55] * 3 + [40] * 3
    assert sum(group.residual_m.sum() for group in groups) == pytest.approx(
        sum(grid.residual_m.sum() for grid in grids)
    )
