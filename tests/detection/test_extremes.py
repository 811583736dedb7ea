"""Thresholds of rare false alarms: against tails that are known, and against counting all vehicles."""

from math import log

import numpy as np
import pytest

from gpsec.detection.calibration import replay
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.extremes import Tail, counted_interval, fit_tail, modelled_thresholds
from gpsec.detection.logs import Grid
from gpsec.detection.rare import Harvest
from gpsec.testing.residuals import make_log


def test_an_exponential_tail_is_extrapolated_by_its_law():
    # Ten peaks an hour for 100 hours, exponential with scale 2: over u there are 10·exp(-u/2) an hour.
    hours = 100.0
    peaks = np.random.default_rng(4).exponential(2.0, 1000)
    level = 2.0 * log(10.0)  # one an hour
    for rate, one in zip((0.1, 0.01), modelled_thresholds(peaks, hours, level, [0.1, 0.01]), strict=True):
        assert one.threshold == pytest.approx(2.0 * log(10.0 / rate), rel=0.15)
        true = 10.0 * np.exp(-one.threshold / 2.0)
        assert one.lo < true < one.hi
        assert one.lo < rate < one.hi


def test_rarer_is_less_certain():
    peaks = np.random.default_rng(6).exponential(2.0, 4000)
    often, seldom = modelled_thresholds(peaks, 400.0, 4.6, [0.1, 0.001])
    assert often.threshold < seldom.threshold
    assert seldom.hi / seldom.lo > often.hi / often.lo


def test_threshold_and_rate_are_inverse_and_heavy_tails_higher():
    light, heavy = Tail(5.0, 1.0, -0.1, 2.0), Tail(5.0, 1.0, 0.3, 2.0)
    for tail in (light, heavy):
        assert tail.rate(tail.threshold(0.01)) == pytest.approx(0.01)
        assert tail.rate(5.0) == 1.0
    assert heavy.threshold(0.01) > light.threshold(0.01)


@pytest.mark.parametrize("peaks", [np.arange(40.0) + 10.0, np.full(200, 7.0), np.zeros(0)])
def test_too_little_is_not_fitted(peaks):
    assert fit_tail(peaks, 10.0, 5.0) is None
    assert modelled_thresholds(peaks, 10.0, 5.0, [0.01]) is None


def test_intervals_of_counts_are_garwoods():
    # Garwood 1936: of 0 counts 0 to 3.689, of 10 counts 4.795 to 18.39.
    assert counted_interval(0, 1.0) == pytest.approx((0.0, 3.689), abs=1e-3)
    assert counted_interval(10, 100.0) == pytest.approx((0.04795, 0.1839), abs=1e-4)


@pytest.mark.parametrize("detector", [ChiSquare(), Cusum(white=(0.5,), slow=(0.8,), tau_s=(60.0,))])
def test_what_is_kept_counts_as_all_vehicles_do(detector):
    grids = [Grid.of([make_log(96, 700, seed=seed)]) for seed in (1, 2)]
    harvest = Harvest(detector, settle_s=10.0)
    for grid in grids:
        harvest.take(grid)
    assert harvest.hours == pytest.approx(2 * 96 * 60.0 / 3600.0)
    near = list(harvest.near.groups())
    # Three hours: the thirty with the largest peaks, and who had a larger one before settling.
    assert 30 <= sum(len(grid.length) for grid in near) < 60
    threshold = float(np.sort(np.concatenate(harvest.peaks))[-3])
    everybody = sum(replay(detector, grid, threshold, 10.0).onsets for grid in grids)
    assert harvest.onsets(threshold, near) == everybody > 0
    # Three hours are too few for what is asked: neither counted nor modelled.
    assert harvest.calibrated() == {"0.1/h": None, "0.01/h": None, "1e-3/h": None}
