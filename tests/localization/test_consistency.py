import numpy as np
import pytest
from scipy.stats import chi2

from gpsec.localization.consistency import along_and_across, chi_square_quantile, consistency, nees, nis


def test_nees_by_hand():
    """Errors of one and two standard deviations: 1 + 4; correlated by 0.6, P⁻¹ = [[1, -0.6], [-0.6, 1]] / 0.64."""
    error = np.array([[2.0, 6.0], [1.0, 1.0]])
    covariance = np.array([[[4.0, 0.0], [0.0, 9.0]], [[1.0, 0.6], [0.6, 1.0]]])
    assert nees(error, covariance) == pytest.approx([5.0, (2.0 - 1.2) / 0.64])


def test_nis_is_the_sum_of_squares():
    assert nis(np.array([[3.0, 4.0], [0.0, -1.0]])).tolist() == [25.0, 1.0]


def test_along_is_ahead_and_across_is_to_the_left():
    yaw = np.array([0.0, np.pi / 2])
    parts = along_and_across(np.array([[1.0, 2.0], [1.0, 2.0]]), yaw)
    assert parts.ravel().tolist() == pytest.approx([1.0, 2.0, 2.0, -1.0])


@pytest.mark.parametrize("probability", [0.025, 0.5, 0.975])
@pytest.mark.parametrize("freedom", [20, 400])
def test_quantiles_are_those_of_scipy(probability, freedom):
    assert chi_square_quantile(probability, freedom) == pytest.approx(chi2.ppf(probability, freedom), rel=0.01)


def test_a_vehicle_counts_once_however_often_it_was_seen():
    """Two vehicles of means 1 and 3, the first seen three times: 2 ± 1.96 · √2/√2."""
    found = consistency(np.array([0.0, 1.0, 2.0, 3.0]), np.array([7, 7, 7, 5]), 2)
    assert (found.mean, found.vehicles, found.freedom) == (2.0, 2, 2)
    assert (found.lo, found.hi) == pytest.approx((2.0 - 1.95996, 2.0 + 1.95996), abs=1e-4)
    assert (found.bound_lo, found.bound_hi) == pytest.approx((chi2.ppf(0.025, 4) / 2, chi2.ppf(0.975, 4) / 2), rel=0.1)


@pytest.mark.parametrize(("sigma", "consistent"), [(1.0, True), (1.5, False), (0.6, False)])
def test_a_filter_that_is_wrong_about_itself_is_found_out(sigma, consistent):
    """200 vehicles whose error lasts: as large as said, half as large again, and smaller."""
    rng = np.random.default_rng(4)
    error = np.repeat(sigma * rng.normal(size=(200, 2)), 20, axis=0)
    squares = nees(error, np.tile(np.eye(2), (4000, 1, 1)))
    assert consistency(squares, np.repeat(np.arange(200), 20), 2).consistent is consistent


def test_one_vehicle_tells_nothing():
    with pytest.raises(ValueError, match="two vehicles or more, found 1"):
        consistency(np.ones(3), np.zeros(3, np.int32), 2)
