import numpy as np
import pytest
from sklearn.metrics import f1_score, precision_score, recall_score

from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import Figures


def test_by_hand():
    tp, fp, fn = np.array([8]), np.array([2]), np.array([4])
    assert metrics.precision(tp, fp, fn).value == 0.8
    assert metrics.recall(tp, fn).value == 8 / 12
    assert metrics.f1(tp, fp, fn).value == pytest.approx(2 * 0.8 * (2 / 3) / (0.8 + 2 / 3))
    assert metrics.rmse(np.array([9.0 + 16.0]), np.array([4])).value == 2.5


def test_like_scikit_learn():
    rng = np.random.default_rng(0)
    truth, alarm = rng.random(500) < 0.3, rng.random(500) < 0.4
    tp, fp, fn = (np.array([x.sum()]) for x in (truth & alarm, ~truth & alarm, truth & ~alarm))
    assert metrics.precision(tp, fp, fn).value == pytest.approx(precision_score(truth, alarm))
    assert metrics.recall(tp, fn).value == pytest.approx(recall_score(truth, alarm))
    assert metrics.f1(tp, fp, fn).value == pytest.approx(f1_score(truth, alarm))


@pytest.mark.parametrize(
    ("counts", "known"),
    [
        ((0, 0, 5), (False, True, True)),  # never in alarm: no precision, recall and F1 are 0
        ((0, 5, 0), (False, False, False)),  # no attacked sample was scored, as under jamming
        ((0, 0, 0), (False, False, False)),
    ],
)
def test_what_is_undefined_is_masked_and_not_nan(counts, known):
    tp, fp, fn = (np.array([count]) for count in counts)
    figures = metrics.precision(tp, fp, fn), metrics.recall(tp, fn), metrics.f1(tp, fp, fn)
    assert tuple(bool(figure.known[0]) for figure in figures) == known
    assert all(figure.value[0] == 0.0 for figure in figures)


def test_quantiles_leave_out_what_is_undefined():
    values = np.array([[1.0, 7.0], [2.0, 0.0], [99.0, 0.0], [3.0, 0.0]])
    known = np.array([[True, False], [True, False], [False, False], [True, False]])
    found = metrics.quantiles(values, known, 0.5)
    np.testing.assert_array_equal(found.value, [2.0, 0.0])
    np.testing.assert_array_equal(found.known, [True, False])
    assert not metrics.quantiles(np.zeros((0, 2)), np.zeros((0, 2), bool), 0.5).known.any()


def test_quantiles_of_a_single_figure():
    values = np.array([1.0, 2.0, 99.0, 3.0])
    assert metrics.quantiles(values, np.array([True, True, False, True]), 0.5).value == 2.0
    assert metrics.quantiles(values, np.ones(4, bool), 0.5).value == 2.5
    assert not metrics.quantiles(values, np.zeros(4, bool), 0.5).known


def test_percentile_interval_by_hand():
    replicates = Figures(np.arange(101.0)[:, None], np.ones((101, 1), bool))
    low, high = metrics.percentile_interval(replicates, 0.9)
    assert (low.value[0], high.value[0]) == pytest.approx((5.0, 95.0))


def test_wilson_interval_by_hand():
    # z = 1.96, 8 of 10: (0.8 + 0.19208) / 1.38416 ∓ 1.96 / 1.38416 · √(0.016 + 0.009604); 0 of 10: z² / (n + z²).
    low, high = metrics.wilson_interval(np.array([8, 0, 10, 0]), np.array([10, 10, 10, 0]), 0.95)
    assert low.value[0] == pytest.approx(0.4901625, abs=1e-5)
    assert high.value[0] == pytest.approx(0.9433178, abs=1e-5)
    assert low.value[1] == 0.0
    assert high.value[1] == pytest.approx(3.8415 / 13.8415, abs=1e-4)
    assert (low.value[2], high.value[2]) == (pytest.approx(10 / 13.8415, abs=1e-4), 1.0)
    np.testing.assert_array_equal(high.known, [True, True, True, False])


def test_upper_bound_of_a_rate_without_events():
    # At the bound, no event in 2 hours has a probability of 2.5 %: ln 40 / 2 an hour.
    bound = metrics.poisson_bound_of_none(np.array([2.0, 0.0]), 0.95)
    assert bound.value[0] == pytest.approx(np.log(40.0) / 2.0)
    assert np.exp(-2.0 * bound.value[0]) == pytest.approx(0.025)
    np.testing.assert_array_equal(bound.known, [True, False])


def test_bootstrap_repeats_and_depends_on_seed_and_label():
    values = np.random.default_rng(0).normal(size=(40, 3))
    first = Bootstrap(7, 50).sums("dsd/drift", values)
    assert first.tobytes() == Bootstrap(7, 50).sums("dsd/drift", values).tobytes()
    # A column on its own has the same draws as among others.
    assert first[:, 1].tobytes() == Bootstrap(7, 50).sums("dsd/drift", values[:, 1:2])[:, 0].tobytes()
    assert not np.array_equal(first, Bootstrap(8, 50).sums("dsd/drift", values))
    assert not np.array_equal(first, Bootstrap(7, 50).sums("dsd/replay", values))


def test_bootstrap_draws_as_many_vehicles_as_there_are():
    sums = Bootstrap(1, 200).sums("x", np.ones((17, 1)))
    np.testing.assert_array_equal(sums, 17.0)
    np.testing.assert_array_equal(Bootstrap(1, 5).sums("x", np.zeros((0, 2))), np.zeros((5, 2)))


def test_bootstrap_spreads_as_theory_says():
    # The standard deviation of a resampled mean is that of the values over √V.
    values = np.random.default_rng(3).normal(size=(100, 1))
    means = Bootstrap(1, 4000).sums("x", values)[:, 0] / 100
    assert means.mean() == pytest.approx(values.mean(), abs=0.01)
    assert means.std() == pytest.approx(values.std() / 10, rel=0.05)


def test_bootstrap_interval_covers_the_truth_about_as_often_as_it_says():
    # 200 fleets of 60 vehicles with a true mean of 1: a 90 % interval holds it in 180 ± 13 (three sigma).
    rng = np.random.default_rng(11)
    covered = 0
    for fleet in range(200):
        sums = Bootstrap(fleet, 300).sums("x", rng.gamma(4.0, 0.25, (60, 1)))
        known = np.ones((300, 1), bool)
        low, high = metrics.percentile_interval(Figures(sums / 60.0, known), 0.9)
        covered += bool(low.value[0] <= 1.0 <= high.value[0])
    assert 163 <= covered <= 193
