"""The contract of a response: `check_response` holds all of it, each function of `RESPONSE_CHECKS` one rule."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.localization.branches import LocalizationState
from gpsec.localization.responses import Response
from gpsec.testing.contract import STEP_S, require
from gpsec.testing.rig import Rig, straight_road

_VEHICLES, _STEPS = 12, 120
_ALL: Ints = np.arange(_VEHICLES, dtype=np.int32)
# With perfect roads and these sensors, dead reckoning is never this far off within the time of a check.
_FAR_M = 10.0


def check_response(kind: type[Response]) -> None:
    """Hold a response to its contract.

    Raises:
        BrokenContractError: it breaks a rule, which is said.
    """
    for check in RESPONSE_CHECKS:
        check(kind)


def drive_rig(kind: type[Response], order: Ints = _ALL, batches: int = 1, steps: int = _STEPS) -> Rig:
    """Return vehicles with noise of their own, alarms, lost fixes and a camera that blinks, after some steps.

    Args:
        kind: the response of their defence.
        order: rows of the vehicles that are localized, in which order.
        batches: in how many parts.
        steps: how many.
    """
    rng = np.random.default_rng(11)
    noise = rng.normal(0.0, 1.0, (_STEPS, _VEHICLES, 5))
    fix = rng.random((_STEPS, _VEHICLES)) < 0.9
    fix[40:60, 3] = False
    alarm = rng.random((_STEPS, _VEHICLES)) < 0.02
    alarm[50:80, :4] = True
    camera = rng.random((_STEPS, _VEHICLES)) < 0.9
    rig = _rig(kind)
    rig.vehicles.rear_m[:, 0] = 100.0 * np.arange(_VEHICLES) + 50.0
    for step in range(steps):
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
        for part in np.array_split(order, batches):
            rig.localize(part)
    return rig


def _rig(kind: type[Response]) -> Rig:
    return Rig(straight_road(), responses=(kind.name,), count=_VEHICLES, others={kind.name: kind})


def same_state(one: LocalizationState, other: LocalizationState, rows: Ints) -> bool:
    """Return whether tracks are in the same state, whatever the rows of their branches."""
    cells: Iterable[tuple[Any, Any, str]] = zip(one.cells, other.cells, one.cells._fields, strict=True)
    filters = zip(*(state.of(0)[0] for state in (one, other)), one.of(0)[0]._fields, strict=True)
    branch = one.of(0)[1][rows], other.of(0)[1][rows]
    return all(a[rows].tobytes() == b[rows].tobytes() for a, b, name in cells if name != "branch") and all(
        a[branch[0]].tobytes() == b[branch[1]].tobytes() for a, b, _ in filters
    )


def it_says_its_name_and_what_it_does(kind: type[Response]) -> None:
    """Hold what a user is told of it."""
    require(isinstance(kind, type) and issubclass(kind, Response), "a response is a subclass of `Response`")
    require(isinstance(getattr(kind, "name", None), str) and kind.name, "a response has a `name`")
    require((kind.__doc__ or "").strip(), "a response has a docstring, whose first line is in lists")


def estimates_are_finite_and_of_the_right_shape(kind: type[Response]) -> None:
    """Hold shapes, that nothing is NaN or infinite, and the covariance."""
    rig = drive_rig(kind)
    filters = rig.filters(kind.name)
    require(filters.mean.shape == (_VEHICLES, kind.filter.states), "a filter has as many states as it says")
    for name, values in filters._asdict().items():
        require(np.isfinite(values).all(), f"`{name}` is finite")
    require(np.abs(rig.error_m(kind.name)).max() < _FAR_M, f"an estimate on a straight road stays within {_FAR_M:g} m")
    variances = np.diagonal(filters.covariance[:, :2, :2], axis1=1, axis2=2)
    require((variances > 0.0).all(), "the variance of a position is above 0")
    lopsided = np.abs(filters.covariance - np.swapaxes(filters.covariance, 1, 2)).max()
    require(lopsided <= 1e-9 * np.abs(filters.covariance).max(), "a covariance is symmetric")
    isolated = bool(filters.isolated_way_m.any())
    require(kind.isolates == isolated, "GNSS is isolated on an alarm just where `isolates` says so")


def the_same_input_gives_the_same_bytes(kind: type[Response]) -> None:
    """Hold determinism."""
    require(same_state(drive_rig(kind).state, drive_rig(kind).state, _ALL), "the same input gives the same bytes")


def the_batch_equals_a_loop_of_singles(kind: type[Response]) -> None:
    """Hold that a filter does not depend on its company, to the last bit."""
    singly = drive_rig(kind, batches=_VEHICLES)
    require(
        same_state(drive_rig(kind).state, singly.state, _ALL),
        "a filter is the same in whatever company it is corrected",
    )


def the_order_of_rows_does_not_matter(kind: type[Response]) -> None:
    """Hold that other rows are left alone, too."""
    order = np.array([7, 2, 9, 3, 0], np.int32)
    some = drive_rig(kind, order)
    require(same_state(drive_rig(kind).state, some.state, order), "the order of the rows does not matter")
    untouched = np.setdiff1d(_ALL, order)
    require(not some.state.cells.started[untouched].any(), "rows that are not localized are left alone")


def a_reset_row_begins_anew(kind: type[Response]) -> None:
    """Hold that a row that was used for another track behaves as a fresh one."""
    rig = drive_rig(kind, steps=70)
    row = np.array([1], np.int32)
    rig.state.reset(row)
    require(same_state(rig.state, _rig(kind).state, row), "a row that is reset begins anew")


def a_copied_row_goes_on_as_its_source(kind: type[Response]) -> None:
    """Hold that all that a filter remembers is in its states: an attack forks the track of its victim."""
    rig = drive_rig(kind, steps=70)
    two, five = np.array([2], np.int32), np.array([5], np.int32)
    rig.state.copy(two, five)
    rig.state.history.copy(two, five)
    seen, tracks = rig.seen, rig.tracks
    for places in (rig.vehicles.rear_m, tracks.fix_m, tracks.paired_m, seen.lane_poly):
        places[5] = places[2]
    for numbers in (seen.speed_mps, seen.yaw_rate_rps, tracks.residual_m):
        numbers[5] = numbers[2]
    for flags in (tracks.fix_valid, tracks.residual_valid, seen.camera_valid, rig.alarm):
        flags[5] = flags[2]
    rig.localize(rig.rows)
    filters = rig.filters(kind.name)
    for structure in (rig.state.cells, filters):
        for name, values in structure._asdict().items():
            equal = name in ("branch", "track") or values[5].tobytes() == values[2].tobytes()
            require(equal, f"a copied track goes on as its source; `{name}` does not")
    require(filters.track.tolist() == rig.rows.tolist(), "every branch knows its track")


RESPONSE_CHECKS: tuple[Callable[[type[Response]], None], ...] = (
    it_says_its_name_and_what_it_does,
    estimates_are_finite_and_of_the_right_shape,
    the_same_input_gives_the_same_bytes,
    the_batch_equals_a_loop_of_singles,
    the_order_of_rows_does_not_matter,
    a_reset_row_begins_anew,
    a_copied_row_goes_on_as_its_source,
)
