"""Paired comparisons, with vehicles whose differences can be counted by hand."""

import numpy as np
import pytest
from scipy.stats import binom

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.paired import against_best, named_together, resampled_means, shares_of_vehicles, sign_test

BOOTSTRAP = Bootstrap(1, 2000, 0.95)


def compared(shares, runs=None):
    runs = np.zeros(len(shares), np.int32) if runs is None else np.asarray(runs, np.int32)
    shares = np.asarray(shares, np.float64)
    return against_best(shares, resampled_means(shares, runs, BOOTSTRAP, "test"), range(shares.shape[1]), 0.95)


def test_a_vehicle_counts_once_whatever_number_of_plans_attacks_it():
    # Vehicle 0 is attacked three times under defence 0 and leaves its lane once; vehicle 1 is attacked once.
    vehicle, defence = np.array([0, 0, 0, 1, 0, 1]), np.array([0, 0, 0, 0, 1, 1])
    out = np.array([True, False, False, True, False, False])
    assert shares_of_vehicles(vehicle, defence, out, (2, 2)) == pytest.approx(np.array([[1 / 3, 0.0], [1.0, 0.0]]))


def test_the_sign_test_is_that_of_a_fair_coin():
    assert sign_test(6, 0) == pytest.approx(2 * 0.5**6)
    assert sign_test(7, 2) == pytest.approx(2 * binom.cdf(2, 9, 0.5))
    assert sign_test(0, 0) == 1.0


def test_equal_defences_are_not_apart_and_the_first_is_called_best():
    best, found = compared(np.ones((40, 2)) * 0.25)
    assert best == 0
    assert [each.apart for each in found] == [False, False]
    assert found[1].mean == found[1].low == found[1].high == 0.0


@pytest.mark.parametrize(("differing", "apart"), [(5, False), (6, True)])
def test_two_defences_are_apart_from_six_vehicles_of_one_sign_on(differing, apart):
    """The sign test of n of n has p = 2^(1-n): 0.0625 of five, 0.031 of six."""
    shares = np.zeros((141, 2))
    shares[:differing, 1] = 1.0
    best, found = compared(shares)
    assert best == 0
    assert (found[1].better, found[1].worse, found[1].apart) == (differing, 0, apart)
    assert found[1].mean == pytest.approx(differing / 141)


def test_with_more_defences_each_has_to_be_further_apart():
    """Of eleven defences each is compared at 0.05 / 10: six of six no longer do, nine of nine do (p = 0.0039)."""
    shares = np.zeros((141, 11))
    shares[:6, 1:] = 1.0
    shares[:9, 10] = 1.0
    _, found = compared(shares)
    assert [each.apart for each in found] == [False] * 10 + [True]


def test_what_vehicles_gain_and_lose_alike_is_no_difference():
    shares = np.zeros((100, 2))
    shares[:20, 0] = 1.0
    shares[20:41, 1] = 1.0
    best, found = compared(shares)
    assert best == 0
    assert (found[1].better, found[1].worse, found[1].apart) == (21, 20, False)
    assert found[1].low < 0.0 < found[1].high


def test_a_difference_within_one_run_of_four_is_not_one_of_the_runs():
    """Thirty vehicles differ, all in one run: with whole runs drawn, a quarter of 0.3 draws has none of them."""
    shares = np.zeros((400, 2))
    shares[:30, 1] = 1.0
    assert compared(shares)[1][1].apart
    assert not compared(shares, np.repeat(np.arange(4), 100))[1][1].apart


def test_names_are_joined():
    assert named_together(["a"]) == "a"
    assert named_together(["a", "b"]) == "a and b"
    assert named_together(["a", "b", "c"]) == "a, b and c"
    assert named_together(["a", "b", "c", "d"]) == "a, b and 2 more"
    assert named_together(["a", "b", "c"], 2) == "a and 2 more"
