import numpy as np
import pytest
from sklearn.metrics import roc_auc_score

from gpsec.outcomes.curves import POINTS, curve, lower_edges
from gpsec.outcomes.histograms import BINS, bin_of
from gpsec.outcomes.tables import read_table

from .story import tell


def histogram(values):
    return np.bincount([bin_of(float(value)) for value in values], minlength=BINS).astype(float)


def test_an_edge_is_the_lowest_statistic_of_its_bin():
    edges = lower_edges()
    for place in (1, 2, 700, BINS - 2, BINS - 1):
        assert bin_of(edges[place]) == place
        assert bin_of(np.nextafter(edges[place], 0.0)) == place - 1


def test_points_by_hand():
    # From above: 8 is a hit, 4 a hit and a false alarm, 2 a false alarm.
    found = curve(histogram([2.0, 4.0]), histogram([4.0, 8.0]))
    assert found.threshold.tolist() == [8.0, 4.0, 2.0]
    assert found.false_positive_rate.tolist() == [0.0, 0.5, 1.0]
    assert found.recall.tolist() == [0.5, 1.0, 1.0]
    assert found.precision.tolist() == pytest.approx([1.0, 2 / 3, 0.5])


def test_few_points_carry_the_area_of_all_statistics():
    rng = np.random.default_rng(3)
    benign, spoofed = rng.exponential(1.0, 5000), 2.0 * rng.exponential(1.0, 2000)
    found = curve(histogram(benign), histogram(spoofed))
    assert len(found.recall) <= POINTS + 2
    x, y = np.r_[0.0, found.false_positive_rate], np.r_[0.0, found.recall]
    labels = np.r_[np.zeros(5000), np.ones(2000)]
    assert np.trapezoid(y, x) == pytest.approx(roc_auc_score(labels, np.r_[benign, spoofed]), abs=0.005)
    assert (np.diff(found.threshold) < 0).all()
    assert (found.false_positive_rate < 0.01).sum() > 5


def test_no_curve_without_positives():
    assert curve(histogram([1.0]), histogram([])) is None


def test_table_of_the_story(tmp_path):
    tell().outcomes.write(tmp_path, "lane", 1, replicates=5)
    table = read_table(tmp_path, "curves")
    assert set(table["attack"]) == {"constant_bias"}
    cusum = table[(table["profile"] == "dsd") & (table["detector"] == "cusum")]
    # All of the statistic is 1 or 2; at 2 these are the alarms: 3 of the 10 samples under attack.
    assert cusum["threshold"].tolist() == [2.0, 1.0]
    assert cusum["recall"].tolist() == pytest.approx([0.3, 1.0])
