"""What holds for every registered detector."""

from dataclasses import replace

import numpy as np
import pytest

from gpsec.detection.alarm import GAP_S, HOLD_S
from gpsec.detection.base import Detector, LabelledDetector, Observation, Verdict
from gpsec.detection.bounds import Oracle
from gpsec.detection.logs import Grid
from gpsec.detection.models import build_detectors, thresholds_for
from gpsec.detection.registry import DETECTORS
from gpsec.fleet import Rows
from gpsec.threads import Threads

from .ask import ask
from .synthetic import SCALE_M, STEP_S, make_log

NAMES = [name for name in DETECTORS if name != Oracle.name]
ALARMING = [name for name in NAMES if name != "never"]
PROFILES = ("first", "second")


@pytest.fixture(scope="module")
def models(model):
    # What the second profile's vehicles learned differs a little.
    forest, network = model.learned["isolation_forest"], model.learned["lstm"]
    other = {
        "cusum": {**model.learned["cusum"], "white": np.asarray(0.7)},
        "isolation_forest": {**forest, "threshold": np.float32(0.9) * forest["threshold"]},
        "lstm": {**network, "weight": np.float32(0.9) * network["weight"]},
    }
    return {("first", "tracked"): model, ("second", "tracked"): replace(model, learned=other)}


@pytest.fixture(scope="module")
def grid():
    return Grid.of([make_log(24, 260, seed=9)])


def detector_of(name, models) -> Detector:
    (detector,) = build_detectors([name], PROFILES, "tracked", models)
    assert isinstance(detector, Detector)
    return detector


def threshold_of(name, models) -> float:
    return float(thresholds_for([name], ["first"], "tracked", "1e-3/sample", models)[0, 0])


def observe(grid, t) -> Observation:
    seen = grid.observe(t)
    return seen._replace(profile=(seen.rows % 2).astype(np.int32))


def take(seen: Observation, chosen) -> Observation:
    names = ("rows", "profile", "residual_m", "valid", "scale_m", "speed_mps", "curvature_per_m", "camera_sigma_m")
    return seen._replace(**{name: np.ascontiguousarray(getattr(seen, name)[chosen]) for name in names})


def run(detector, grid, threshold, steps=None, state=None, threads=None):
    """Return (T, V) statistic, scored, alarm."""
    state = detector.new_state(len(grid.length)) if state is None else state
    results = []
    for t in range(len(grid.valid) if steps is None else steps):
        seen = observe(grid, t)
        results.append(ask(detector, state, seen, np.full(len(seen.rows), threshold), threads))
    return tuple(np.stack([getattr(r, key) for r in results]) for key in ("statistic", "scored", "alarm"))


def spoofed(grid, first, offset_m):
    residual = grid.residual_m.copy()
    residual[first:] += np.where(grid.valid[first:], offset_m, 0.0)
    return replace(grid, residual_m=residual)


def clean(vehicles, steps):
    """Return a grid of valid residuals of exactly zero."""
    log = make_log(vehicles, steps, seed=0, white=0.0, slow=0.0, chord_m=0.0, gaps=False)
    return Grid.of([log])


@pytest.mark.parametrize("name", NAMES)
class TestEveryDetector:
    def test_shapes_types_and_masks(self, name, models, grid):
        statistic, scored, alarm = run(detector_of(name, models), grid, threshold_of(name, models))
        assert (statistic.dtype, scored.dtype, alarm.dtype) == (np.float64, np.bool_, np.bool_)
        assert statistic.shape == scored.shape == alarm.shape == grid.valid.shape
        assert np.isfinite(statistic).all()
        assert (statistic[~scored] == 0.0).all()
        assert not (scored & ~grid.valid).any()
        assert (statistic[scored] >= 0.0).all()
        assert scored[grid.valid].mean() > 0.9

    def test_alarm_is_the_statistic_over_the_threshold_where_scored(self, name, models, grid):
        threshold = threshold_of(name, models)
        statistic, scored, alarm = run(detector_of(name, models), spoofed(grid, 100, 1.5), threshold)
        assert np.array_equal(alarm[scored], (statistic > threshold)[scored])

    def test_same_input_gives_same_bytes_for_any_number_of_threads(self, name, models, grid, monkeypatch):
        monkeypatch.setattr(Threads, "MIN_ROWS", 1)
        threads = Threads(2)
        try:
            once = run(detector_of(name, models), grid, threshold_of(name, models))
            again = run(detector_of(name, models), grid, threshold_of(name, models), threads=threads)
        finally:
            threads.close()
        assert [a.tobytes() for a in once] == [a.tobytes() for a in again]

    def test_batch_equals_loop_of_singles(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        attacked = spoofed(grid, 100, 1.5)
        batch = run(detector, attacked, threshold)
        state = detector.new_state(len(grid.length))
        for t in range(len(grid.valid)):
            seen = observe(attacked, t)
            for i in range(len(seen.rows)):
                one = ask(detector, state, take(seen, [i]), np.asarray([threshold]))
                got = one.statistic.tobytes(), one.scored.tobytes(), one.alarm.tobytes()
                assert got == tuple(a[t, i : i + 1].tobytes() for a in batch)

    def test_large_batch_equals_small_ones(self, name, models):
        # Kernels take rows in blocks; some of these are full, and the last one is not.
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        grid = spoofed(Grid.of([make_log(600, 30, seed=12)]), 20, 1.5)
        batch = run(detector, grid, threshold)
        state = detector.new_state(600)
        for t in range(30):
            for chosen in np.array_split(np.arange(600), 37):
                got = ask(detector, state, take(observe(grid, t), chosen), np.full(len(chosen), threshold))
                assert [a.tobytes() for a in got] == [a[t, chosen].tobytes() for a in batch]

    def test_order_of_rows_does_not_matter(self, name, models, grid, rng):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        batch = run(detector, grid, threshold)
        state = detector.new_state(len(grid.length))
        for t in range(len(grid.valid)):
            order = rng.permutation(len(grid.length))
            got = ask(detector, state, take(observe(grid, t), order), np.full(len(order), threshold))
            assert got.statistic.tobytes() == batch[0][t][order].tobytes()
            assert got.alarm.tobytes() == batch[2][t][order].tobytes()

    def test_mixed_profiles_answer_as_each_alone(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        mixed = run(detector, grid, threshold)
        for p, profile in enumerate(PROFILES):
            (alone,) = build_detectors([name], [profile], "tracked", models)
            state = alone.new_state(len(grid.length))
            for t in range(len(grid.valid)):
                seen = take(observe(grid, t), np.arange(p, len(grid.length), 2))
                seen = seen._replace(profile=np.zeros_like(seen.profile))
                got = ask(alone, state, seen, np.full(len(seen.rows), threshold))
                assert [a.tobytes() for a in got] == [a[t, p::2].tobytes() for a in mixed]

    def test_reset_rows_begin_anew(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        first = run(detector, grid, threshold)
        state = detector.new_state(len(grid.length))
        run(detector, spoofed(grid, 50, 2.0), threshold, state=state)
        state.reset(np.arange(len(grid.length), dtype=np.int32))
        again = run(detector, grid, threshold, state=state)
        assert [a.tobytes() for a in first] == [a.tobytes() for a in again]

    def test_copied_row_goes_on_like_the_original(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        state = detector.new_state(len(grid.length))
        run(detector, spoofed(grid, 50, 2.0), threshold, steps=120, state=state)
        state.copy(np.asarray([3]), np.asarray([5]))
        seen = take(observe(grid, 120), [3])
        original = ask(detector, state, seen, np.asarray([threshold]))
        fork = ask(detector, state, seen._replace(rows=np.asarray([5], np.int32)), np.asarray([threshold]))
        assert original.statistic.tobytes() == fork.statistic.tobytes()

    def test_no_score_depends_on_later_data(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        whole = run(detector, grid, threshold)
        changed = run(detector, spoofed(grid, 130, 3.0), threshold)
        assert [a[:130].tobytes() for a in whole] == [a[:130].tobytes() for a in changed]

    def test_only_observed_rows_change(self, name, models, grid):
        detector, threshold = detector_of(name, models), threshold_of(name, models)
        state = detector.new_state(len(grid.length))
        run(detector, grid, threshold, steps=40, state=state)
        before = _bytes_of(state, slice(1, None))
        ask(detector, state, take(observe(grid, 40), [0]), np.asarray([threshold]))
        assert _bytes_of(state, slice(1, None)) == before

    def test_an_absurd_residual_stays_finite(self, name, models):
        for offset in (1e6, -1e6):
            statistic, _, _ = run(detector_of(name, models), spoofed(clean(2, 40), 20, offset), 10.0)
            assert np.isfinite(statistic).all()


@pytest.mark.parametrize("name", ALARMING)
@pytest.mark.parametrize("side", [-1.0, 1.0])
class TestEveryAlarm:
    def test_ten_sigma_bias_alarms_on_every_vehicle(self, name, side, models):
        threshold = threshold_of(name, models)
        grid = spoofed(Grid.of([make_log(30, 200, seed=4, gaps=False)]), 150, side * 10.0 * SCALE_M)
        statistic, _, alarm = run(detector_of(name, models), grid, threshold)
        assert alarm[150:160].any(axis=0).all()
        assert statistic[150:160].max(axis=0).min() > threshold

    def test_larger_bias_is_more_anomalous(self, name, side, models):
        peaks = []
        # Sums stay at 0 below their slack, which is larger where the network expects errors that last.
        for bias in (0.0, 3.0 if name == "lstm_cusum" else 2.0, 5.0):
            grid = spoofed(clean(1, 60), 40, side * bias * SCALE_M)
            statistic, _, _ = run(detector_of(name, models), grid, np.inf)
            peaks.append(statistic[40:46].max())
        assert peaks[0] < peaks[1] < peaks[2]

    def test_alarm_ends_soon_after_the_attack(self, name, side, models):
        grid = clean(1, 400)
        grid.residual_m[100:300] = side * 8.0 * SCALE_M
        _, _, alarm = run(detector_of(name, models), grid, threshold_of(name, models))
        assert alarm[110:300].all()
        assert not alarm[310:].any()


@pytest.mark.parametrize("name", ALARMING)
class TestGaps:
    def with_gap(self, gap, bias=8.0, after=0.0, total=300):
        grid = clean(1, total)
        grid.residual_m[60:100] = bias * SCALE_M
        grid.residual_m[100 + gap :] = after * SCALE_M
        grid.valid[100 : 100 + gap] = False
        grid.residual_m[100 : 100 + gap] = 0.0
        return grid

    def test_alarm_is_held_in_a_gap_and_then_ends(self, name, models):
        hold = round(HOLD_S / STEP_S)
        grid = self.with_gap(150)
        _, scored, alarm = run(detector_of(name, models), grid, threshold_of(name, models))
        assert not scored[100:250].any()
        assert alarm[99 : 100 + hold].all()
        assert not alarm[100 + hold : 250].any()

    def test_no_alarm_begins_in_a_gap(self, name, models):
        grid = self.with_gap(150, bias=0.0)
        _, _, alarm = run(detector_of(name, models), grid, threshold_of(name, models))
        assert not alarm.any()

    def test_long_gap_forgets(self, name, models):
        gap = round(HOLD_S / STEP_S) + 5
        threshold = threshold_of(name, models)
        grid = self.with_gap(gap, after=1.0)
        after = run(detector_of(name, models), grid, threshold)
        columns = ("residual_m", "valid", "speed_mps", "curvature_per_m", "camera_sigma_m")
        rest = {key: getattr(grid, key)[100 + gap :] for key in columns}
        anew = run(detector_of(name, models), replace(grid, length=grid.length - 100 - gap, **rest), threshold)
        assert after[0][100 + gap :].tobytes() == anew[0].tobytes()
        assert after[1][100 + gap :].tobytes() == anew[1].tobytes()

    def test_short_gap_does_not_forget(self, name, models):
        gap = round(GAP_S / STEP_S) - 1
        _, scored, _ = run(detector_of(name, models), self.with_gap(gap), threshold_of(name, models))
        assert scored[100 + gap]


def _bytes_of(state: Rows, rows) -> list[bytes]:
    return [np.ascontiguousarray(array[rows]).tobytes() for _, array in state._arrays()]


def test_oracle_is_told_the_truth():
    (oracle,) = build_detectors(["oracle"], PROFILES, "tracked", {})
    assert isinstance(oracle, LabelledDetector)
    attacked = np.asarray([True, False, True])
    rows = np.asarray([2, 0, 3], np.int32)
    verdict = Verdict.blank(4)
    oracle.update(rows, attacked, verdict)
    statistic, scored, alarm = verdict.at(rows)
    assert alarm.tolist() == [True, False, True]
    assert statistic.tolist() == [1.0, 0.0, 1.0]
    assert scored.all()
    assert not any(column[1, 0] for column in verdict[:3])


def test_never_is_silent(models, grid):
    _, scored, alarm = run(detector_of("never", models), spoofed(grid, 10, 5.0), 1.0)
    assert not alarm.any()
    assert np.array_equal(scored, grid.valid)
