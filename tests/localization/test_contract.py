"""What holds for every registered response."""

import numpy as np
import pytest

from gpsec.localization.branches import LocalizationState
from gpsec.localization.registry import RESPONSES
from gpsec.localization.responses import Response

from .rig import STEP_S, Rig

M, STEPS = 12, 120
pytestmark = pytest.mark.parametrize("response", list(RESPONSES))


def drive(straight, response: str, order: np.ndarray, batches: int = 1, last: int = STEPS) -> Rig:
    """Vehicles `order` of M, each with noise of its own, alarms, lost fixes and a camera that blinks."""
    rng = np.random.default_rng(11)
    noise = rng.normal(0.0, 1.0, (STEPS, M, 5))
    fix = rng.random((STEPS, M)) < 0.9
    fix[40:60, 3] = False
    alarm = rng.random((STEPS, M)) < 0.02
    alarm[50:80, :4] = True
    camera = rng.random((STEPS, M)) < 0.9
    rig = Rig(straight, responses=(response,), count=M)
    rig.vehicles.rear_m[:, 0] = 100.0 * np.arange(M) + 50.0
    for step in range(last):
        n = noise[step]
        rig.vehicles.rear_m[:, 0] += rig.speed_mps * STEP_S
        rig.seen.speed_mps[:] = rig.speed_mps + 0.05 * n[:, 0]
        rig.seen.yaw_rate_rps[:] = 0.002 * n[:, 1]
        rig.seen.lane_poly[:, 0] = 0.08 * n[:, 2]
        rig.tracks.fix_m[:] = rig.vehicles.rear_m + 0.1 * n[:, 3:]
        rig.tracks.fix_m[:, 1] += np.where(alarm[step], 2.4, 0.0)
        rig.tracks.fix_valid[:], rig.seen.camera_valid[:] = fix[step], camera[step]
        rig.tracks.residual_valid[:] = fix[step] & camera[step]
        rig.tracks.paired_m[:] = rig.tracks.fix_m
        rig.tracks.residual_m[:] = -rig.seen.lane_poly[:, 0] - rig.tracks.fix_m[:, 1]
        rig.alarm[:] = alarm[step][:, np.newaxis]
        for part in np.array_split(order.astype(np.int32), batches):
            rig.localize(part)
    return rig


def same(one: LocalizationState, other: LocalizationState, rows: np.ndarray) -> bool:
    """Whether tracks are in the same state, whatever the rows of their branches."""
    cells = zip(one.cells, other.cells, one.cells._fields, strict=True)
    filters = zip(*(state.of(0)[0] for state in (one, other)), one.of(0)[0]._fields, strict=True)
    branch = one.of(0)[1][rows], other.of(0)[1][rows]
    return all(a[rows].tobytes() == b[rows].tobytes() for a, b, name in cells if name != "branch") and all(
        a[branch[0]].tobytes() == b[branch[1]].tobytes() for a, b, _ in filters
    )


def test_it_says_its_name_and_what_it_is(response):
    kind = RESPONSES[response]
    assert kind.name == response
    assert issubclass(kind, Response)
    assert kind.__doc__


def test_estimates_are_finite_and_of_the_right_shape(straight, response):
    rig = drive(straight, response, np.arange(M))
    filters = rig.filters(response)
    assert filters.mean.shape == (M, RESPONSES[response].filter.states)
    for structure in (rig.state.cells, filters):
        for name, array in zip(structure._fields, structure, strict=True):
            assert len(array) == M
            assert np.isfinite(array).all(), name
    assert abs(rig.error_m(response)).max() < 10.0
    assert (np.diagonal(filters.covariance[:, :2, :2], axis1=1, axis2=2) > 0.0).all()
    assert RESPONSES[response].isolates == filters.isolated_way_m.any()


def test_deterministic(straight, response):
    one, other = (drive(straight, response, np.arange(M)) for _ in range(2))
    assert same(one.state, other.state, np.arange(M))


def test_batch_is_a_loop_of_singles(straight, response):
    together, singly = drive(straight, response, np.arange(M)), drive(straight, response, np.arange(M), batches=M)
    assert same(together.state, singly.state, np.arange(M))


def test_the_order_of_rows_and_the_company_do_not_matter(straight, response):
    order = np.array([7, 2, 9, 3, 0])
    together, some = drive(straight, response, np.arange(M)), drive(straight, response, order)
    assert same(together.state, some.state, order)
    untouched = np.setdiff1d(np.arange(M), order)
    assert not some.state.cells.started[untouched].any()


def test_a_reset_row_is_as_new_and_a_copied_one_goes_on_as_its_source(straight, response):
    rig = drive(straight, response, np.arange(M), last=70)
    two, five = np.array([2], np.int32), np.array([5], np.int32)
    rig.state.copy(two, five)
    rig.state.history.copy(two, five)
    rig.state.reset(np.array([1], np.int32))
    assert same(rig.state, Rig(straight, responses=(response,), count=M).state, np.array([1]))
    for array in (rig.vehicles.rear_m, rig.tracks.fix_m, rig.tracks.paired_m, rig.seen.lane_poly):
        array[5] = array[2]
    for array in (rig.seen.speed_mps, rig.seen.yaw_rate_rps, rig.tracks.residual_m, rig.alarm):
        array[5] = array[2]
    for flags in (rig.tracks.fix_valid, rig.tracks.residual_valid, rig.seen.camera_valid):
        flags[5] = flags[2]
    rig.localize(rig.rows)
    filters = rig.filters(response)
    for structure in (rig.state.cells, filters):
        for name, array in zip(structure._fields, structure, strict=True):
            if name not in ("branch", "track"):
                assert array[5].tobytes() == array[2].tobytes(), name
    assert filters.track.tolist() == rig.rows.tolist()
