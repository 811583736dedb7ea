import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import average_precision_score, roc_auc_score

from gpsec.outcomes.histograms import BINS, PER_OCTAVE, areas, bin_of, matched, negatives

from .scene import Scene


def histogram(values, weight=1):
    return np.bincount([bin_of(float(value)) for value in values], minlength=BINS) * weight


def test_bins_by_hand():
    assert bin_of(0.0) == bin_of(-3.0) == bin_of(9.5e-7) == 0
    assert bin_of(2.0**-20) == 1
    assert bin_of(1.0) == 1 + 20 * PER_OCTAVE
    assert bin_of(1.5) == 1 + 20 * PER_OCTAVE + PER_OCTAVE // 2
    assert bin_of(np.nextafter(2.0, 0.0)) == 21 * PER_OCTAVE
    assert bin_of(np.nextafter(2.0**20, 0.0)) == BINS - 2
    assert bin_of(2.0**20) == bin_of(np.inf) == BINS - 1


@given(st.floats(2.0**-20, 2.0**20, exclude_max=True), st.floats(1.0, 1.02))
def test_bins_keep_the_order_and_are_less_than_one_percent_wide(statistic, factor):
    assert bin_of(statistic) <= bin_of(statistic * factor)
    assert bin_of(statistic) < bin_of(statistic * (1.0 + 1.0 / PER_OCTAVE + 1e-12))


@pytest.mark.parametrize("seed", range(3))
def test_areas_equal_scikit_learn_on_statistics_that_bins_tell_apart(seed):
    rng = np.random.default_rng(seed)
    benign, spoofed = rng.integers(0, 30, 400) / 8, rng.integers(10, 40, 150) / 8
    labels = np.r_[np.zeros(400), np.ones(150)]
    found = areas(histogram(benign).astype(float), histogram(spoofed).astype(float))
    statistics = np.r_[benign, spoofed]
    assert found.roc == pytest.approx(roc_auc_score(labels, statistics), abs=1e-12)
    assert found.pr == pytest.approx(average_precision_score(labels, statistics), abs=1e-12)


@pytest.mark.parametrize("spread", [lambda rng, n: rng.exponential(1.0, n), lambda rng, n: rng.beta(8, 10, n)])
def test_areas_of_continuous_statistics_are_within_the_resolution(spread):
    rng = np.random.default_rng(1)
    benign, spoofed = spread(rng, 3000), 1.3 * spread(rng, 1000)
    labels = np.r_[np.zeros(3000), np.ones(1000)]
    found = areas(histogram(benign).astype(float), histogram(spoofed).astype(float))
    assert found.roc == pytest.approx(roc_auc_score(labels, np.r_[benign, spoofed]), abs=0.002)
    assert found.pr == pytest.approx(average_precision_score(labels, np.r_[benign, spoofed]), abs=0.01)


def test_areas_by_hand():
    # Thresholds from above: 8 is a hit, 4 is one hit and one false, 2 is false. ROC: two of four pairs are in order,
    # and (8, 4), (4, 4), (8, 2), (4, 2) are the pairs: 1 + 1/2 + 1 + 1 of 4. PR: 1/2 · 1 + 1/2 · 2/3.
    found = areas(histogram([2.0, 4.0]).astype(float), histogram([4.0, 8.0]).astype(float))
    assert found.roc == pytest.approx(3.5 / 4)
    assert found.pr == pytest.approx(0.5 + 1 / 3)


def test_a_statistic_that_never_moves_is_worth_nothing():
    found = areas(histogram([0.0] * 30).astype(float), histogram([0.0] * 10).astype(float))
    assert found.roc == 0.5
    assert found.pr == 0.25  # the share of positives


def test_areas_need_both_classes():
    assert areas(np.zeros(BINS), histogram([1.0]).astype(float)) is None
    assert areas(histogram([1.0]).astype(float), np.zeros(BINS)) is None


def test_negatives_are_distributed_as_without_an_attack():
    weights = negatives(histogram([1.0] * 30 + [2.0] * 10), scored=20)
    assert [weights[bin_of(s)] for s in (1.0, 2.0, 4.0)] == [15.0, 5.0, 0.0]
    assert not negatives(np.zeros(BINS, np.int64), scored=9).any()


def test_a_matched_threshold_has_the_false_alarms_that_are_allowed():
    # 10,000 benign samples, ten of them at 4 and five at 8; of the attacked ones a half at 8, a quarter at 4.
    benign = histogram([1.0] * 9985 + [4.0] * 10 + [8.0] * 5)
    attacked = histogram([8.0] * 50 + [4.0] * 25 + [1.0] * 25)
    found = matched(benign, attacked, allowed=10.0)
    assert found is not None
    assert 4.0 < found.threshold < 4.1  # the bin of 4 is over: with it there would be 15
    assert found.recall == 0.5
    assert matched(benign, attacked, allowed=15.0).recall == 0.75
    assert matched(benign, attacked, allowed=4.0) is None  # too few to tell
    assert matched(benign, np.zeros(BINS, np.int64), allowed=10.0) is None


def test_alarms_at_any_threshold_follow_from_the_rises():
    # The statistic of a benign vehicle: a threshold of 1.5 would raise three alarms, one of 3 two, one of 6 one.
    scene = Scene(capacity=2)
    for step, value in enumerate([1.0, 2.0, 2.5, 1.0, 4.0, 1.0, 1.0, 8.0, 5.0]):
        scene.statistic[0, 0] = value
        scene.observe(step, [0])
    raised = np.cumsum(scene.outcomes.rises[0, 0, ::-1])[::-1]
    assert [raised[bin_of(threshold)] for threshold in (1.5, 3.0, 6.0, 9.0)] == [3, 2, 1, 0]


@pytest.mark.parametrize(("pause", "alarms"), [(50, 1), (51, 2)])
def test_an_alarm_is_one_alarm_while_it_is_held(pause, alarms):
    scene = Scene(capacity=2)
    for step in range(pause + 2):
        scene.scored[0] = step in (0, pause + 1)
        scene.answers.unscored_steps[0] = 0 if scene.scored[0, 0] else step
        scene.statistic[0, 0] = 4.0 * scene.scored[0, 0]
        scene.observe(step, [0])
    assert np.cumsum(scene.outcomes.rises[0, 0, ::-1])[::-1][bin_of(3.0)] == alarms
