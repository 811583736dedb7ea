"""The contract of a detector: `check_detector` holds all of it, each function of `DETECTOR_CHECKS` one rule."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.alarm import GAP_S
from gpsec.detection.base import Detector
from gpsec.detection.channels import Channels
from gpsec.detection.logs import Grid
from gpsec.testing.contract import STEP_S, require
from gpsec.testing.detector_bench import CASE_PROFILES, DetectorCase, observe, take
from gpsec.testing.residuals import SCALE_M, benign, make_log, noiseless, spoofed, with_gap
from gpsec.types.points import HOLD_S


def check_detector(build: Callable[[Sequence[str]], Detector], threshold: float, slack: float = 1.0) -> None:
    """Hold a detector to its contract.

    Args:
        build: returns the detector for sensor profiles, of which there are one or two; where nothing is learned,
            ``lambda profiles: MyDetector()``.
        threshold: that benign residuals of `gpsec.testing.residuals.make_log` seldom pass.
        slack: a bias of twice this multiple of the scale is more anomalous than none.

    Raises:
        BrokenContractError: it breaks a rule, which is said.
    """
    case = DetectorCase(build, threshold, slack)
    for check in DETECTOR_CHECKS:
        check(case)


def answers_have_shapes_types_and_masks(case: DetectorCase) -> None:
    """Hold types, finite and non-negative statistics, and that what is not valid is not scored."""
    grid = benign()
    statistic, scored, _ = case.run(grid)
    require(np.isfinite(statistic).all(), "a statistic is finite")
    require((statistic[~scored] == 0.0).all(), "a statistic is 0 where nothing is scored")
    require(not (scored & ~grid.valid).any(), "nothing is scored without a valid residual")
    require((statistic[scored] >= 0.0).all(), "a statistic is at least 0")
    require(scored[grid.valid].mean() > 0.9, "more than nine tenths of the valid residuals are scored")


def an_alarm_is_a_statistic_over_the_threshold(case: DetectorCase) -> None:
    """Hold what an alarm is, where there is a score."""
    statistic, scored, alarm = case.run(spoofed(benign(), 100, 1.5))
    require(np.array_equal(alarm[scored], (statistic > case.threshold)[scored]), "alarm where statistic > threshold")


def the_same_input_gives_the_same_bytes_for_any_threads(case: DetectorCase) -> None:
    """Hold determinism, also where rows are split among threads."""
    threads = Threads(2)
    threads.MIN_ROWS = 1
    try:
        again = case.run(benign(), threads=threads)
    finally:
        threads.close()
    require(case.run(benign()).bytes() == again.bytes(), "the same input gives the same bytes, for any threads")


def a_batch_equals_a_loop_of_singles(case: DetectorCase) -> None:
    """Hold that a row's answer does not depend on its company, to the last bit."""
    grid = case.watch(spoofed(benign(), 100, 1.5))
    batch, bench = case.run(grid), case.bench(len(grid.length))
    for t in range(len(grid.valid)):
        seen = observe(grid, t)
        for i in range(len(seen.rows)):
            one = case.ask(bench, take(seen, [i]))
            equal = one.bytes() == batch.at((t, slice(i, i + 1))).bytes()
            require(equal, "a row is the same in whatever company it is computed")


def a_large_batch_equals_small_ones(case: DetectorCase) -> None:
    """Hold the same for more rows than a block has."""
    grid = case.watch(spoofed(benign(600, 30, seed=12), 20, 1.5))
    batch, bench = case.run(grid), case.bench(600)
    for t in range(30):
        for chosen in np.array_split(np.arange(600), 37):
            got = case.ask(bench, take(observe(grid, t), chosen))
            require(got.bytes() == batch.at((t, chosen)).bytes(), "a large batch equals small ones")


def the_order_of_rows_does_not_matter(case: DetectorCase) -> None:
    """Hold that state and answer go by `rows`."""
    grid, rng = case.watch(benign()), np.random.default_rng(5)
    batch, bench = case.run(grid), case.bench(len(grid.length))
    for t in range(len(grid.valid)):
        order = rng.permutation(len(grid.length))
        got = case.ask(bench, take(observe(grid, t), order))
        require(got.bytes() == batch.at((t, order)).bytes(), "the order of the rows does not matter")


def mixed_profiles_answer_as_each_alone(case: DetectorCase) -> None:
    """Hold that a vehicle is judged by what was learned on its own profile."""
    grid = case.watch(benign())
    mixed = case.run(grid)
    for p, profile in enumerate(CASE_PROFILES):
        alone = case.bench(len(grid.length), [profile])
        for t in range(len(grid.valid)):
            seen = take(observe(grid, t), np.arange(p, len(grid.length), 2))
            seen = seen._replace(profile=np.zeros_like(seen.profile))
            got = case.ask(alone, seen)
            require(got.bytes() == mixed.at((t, slice(p, None, 2))).bytes(), "profiles answer as each alone")


def rows_that_are_reset_begin_anew(case: DetectorCase) -> None:
    """Hold that nothing is left of a vehicle that is gone."""
    grid = benign()
    bench = case.bench(len(grid.length))
    case.run(spoofed(grid, 50, 2.0), bench=bench)
    bench.reset(np.arange(len(grid.length), dtype=np.int32))
    require(case.run(grid, bench=bench).bytes() == case.run(grid).bytes(), "a row that is reset begins anew")


def a_row_that_is_copied_goes_on_like_the_original(case: DetectorCase) -> None:
    """Hold that all state is in the arrays: a track is forked by copying them."""
    grid = case.watch(spoofed(benign(), 50, 2.0))
    bench = case.bench(len(grid.length))
    case.run(grid, steps=120, bench=bench)
    bench.copy(np.asarray([3], np.int32), np.asarray([5], np.int32))
    seen = take(observe(grid, 120), [3])
    original = case.ask(bench, seen)
    fork = case.ask(bench, seen._replace(rows=np.asarray([5], np.int32)))
    require(original.bytes() == fork.bytes(), "a copied row goes on like the original; all state is in its arrays")


def no_score_depends_on_later_data(case: DetectorCase) -> None:
    """Hold causality."""
    changed = case.run(spoofed(benign(), 130, 3.0))
    part = slice(130)
    require(case.run(benign()).at(part).bytes() == changed.at(part).bytes(), "no score depends on later data")


def only_observed_rows_change(case: DetectorCase) -> None:
    """Hold that the state of others is left alone."""
    grid = case.watch(benign())
    bench = case.bench(len(grid.length))
    case.run(grid, steps=40, bench=bench)
    before = _bytes_of(bench.state)
    case.ask(bench, take(observe(grid, 40), [0]))
    require(_bytes_of(bench.state) == before, "only the state of observed rows changes")


def an_absurd_residual_stays_finite(case: DetectorCase) -> None:
    """Hold that a residual of 1,000 km, either way, is scored with a number."""
    for offset_m in (1e6, -1e6):
        require(np.isfinite(case.run(spoofed(noiseless(2, 40), 20, offset_m)).statistic).all(), "a statistic is finite")


def a_bias_of_ten_scales_alarms_on_every_vehicle(case: DetectorCase) -> None:
    """Hold that what is obvious is seen within a second, on either side."""
    for side in (-1.0, 1.0):
        grid = spoofed(Grid.of([make_log(30, 200, seed=4, gaps=False)]), 150, side * 10.0 * SCALE_M)
        statistic, _, alarm = case.run(grid)
        seen = alarm[150:160].any(axis=0).all() and statistic[150:160].max(axis=0).min() > case.threshold
        require(seen, "a bias of ten scales, either way, raises an alarm within a second")


def a_larger_bias_is_more_anomalous(case: DetectorCase) -> None:
    """Hold that a statistic grows with the bias, on either side, beyond what may be taken for normal."""
    for side in (-1.0, 1.0):
        grids = [spoofed(noiseless(1, 60), 40, side * bias * SCALE_M) for bias in (0.0, 2.0 * case.slack, 5.0)]
        peaks = [replace(case, threshold=np.inf).run(grid).statistic[40:46].max() for grid in grids]
        require(peaks[0] < peaks[1] < peaks[2], "a larger bias is more anomalous, on either side")


def an_alarm_ends_soon_after_the_attack(case: DetectorCase) -> None:
    """Hold that an alarm lasts as long as the bias, and no more than a second longer."""
    for side in (-1.0, 1.0):
        grid = noiseless(1, 400)
        grid.residual_m[100:300] = side * 8.0 * SCALE_M
        alarm = case.run(grid).alarm
        require(alarm[110:300].all(), "an alarm lasts while there is a bias of eight scales")
        require(not alarm[310:].any(), "an alarm ends within a second after the bias")


def an_alarm_is_held_in_a_gap_and_then_ends(case: DetectorCase) -> None:
    """Hold `HOLD_S`, and that no alarm begins without a residual."""
    hold = round(HOLD_S / STEP_S)
    _, scored, alarm = case.run(with_gap(150))
    require(not scored[100:250].any(), "nothing is scored in a gap")
    require(alarm[99 : 100 + hold].all(), "an alarm is held in a gap for HOLD_S; see gpsec.detection.alarm")
    require(not alarm[100 + hold : 250].any(), "an alarm ends after HOLD_S without a score")
    require(not case.run(with_gap(150, bias=0.0)).alarm.any(), "no alarm begins in a gap")


def a_long_gap_forgets_and_a_short_one_does_not(case: DetectorCase) -> None:
    """Hold `GAP_S`: behind it, a window begins anew."""
    gap = round(HOLD_S / STEP_S) + 5
    grid = case.watch(with_gap(gap, after=1.0))
    columns = ("residual_m", "valid", "speed_mps", "curvature_per_m", "camera_sigma_m")
    rest: dict[str, Any] = {key: getattr(grid, key)[100 + gap :] for key in columns}
    if grid.channels is not None:
        rest["channels"] = Channels._make(array[100 + gap :] for array in grid.channels)
    anew = case.run(replace(grid, length=grid.length - 100 - gap, **rest))
    after = case.run(grid).at(slice(100 + gap, None))
    require(after.bytes()[:2] == anew.bytes()[:2], "after a gap of more than GAP_S, a window begins anew")
    short = round(GAP_S / STEP_S) - 1
    require(case.run(with_gap(short)).scored[100 + short], "a gap of less than GAP_S does not empty a window")


def _bytes_of(state: Table[Any]) -> list[bytes]:
    """Return the state of all rows but the first."""
    return [np.ascontiguousarray(array[1:]).tobytes() for array in state.arrays()]


DETECTOR_CHECKS: tuple[Callable[[DetectorCase], None], ...] = (
    answers_have_shapes_types_and_masks,
    an_alarm_is_a_statistic_over_the_threshold,
    the_same_input_gives_the_same_bytes_for_any_threads,
    a_batch_equals_a_loop_of_singles,
    a_large_batch_equals_small_ones,
    the_order_of_rows_does_not_matter,
    mixed_profiles_answer_as_each_alone,
    rows_that_are_reset_begin_anew,
    a_row_that_is_copied_goes_on_like_the_original,
    no_score_depends_on_later_data,
    only_observed_rows_change,
    an_absurd_residual_stays_finite,
    a_bias_of_ten_scales_alarms_on_every_vehicle,
    a_larger_bias_is_more_anomalous,
    an_alarm_ends_soon_after_the_attack,
    an_alarm_is_held_in_a_gap_and_then_ends,
    a_long_gap_forgets_and_a_short_one_does_not,
)
