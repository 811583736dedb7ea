import pytest

from gpsec.pipeline.consistency import ISOLATED, TRUSTING, measure_consistency
from gpsec.scenario import load_scenario

# One profile of good and one of bad GNSS, with maps of 2 and 4 m; all four are in docs/localization.md.
PROFILES = ("carla", "consumer")


@pytest.fixture(scope="module", params=PROFILES)
def found(request, repository):
    return measure_consistency(load_scenario(repository / "scenarios" / "sharp_turns"), request.param, 120.0)


def test_filters_that_trust_gnss_are_as_far_off_as_they_say(found):
    for name in TRUSTING:
        assert found[name, "NEES position"].vehicles > 60
        assert found[name, "NEES position"].consistent
        assert found[name, "NIS"].consistent


def test_ukf5_stays_near_what_it_says_and_the_papers_ukf_does_not(found):
    """Isolated for up to 30 s: slow errors that are states of the one are white noise to the other."""
    assert 1.0 < found["ukf5", "NEES position"].mean < 3.0
    assert found["ukf", "NEES position"].mean > 2.0 * found["ukf5", "NEES position"].mean


def test_no_filter_lags_behind(found):
    """The mean error along the way, over vehicles, is none."""
    for name in (*TRUSTING, *ISOLATED):
        along = found[name, "mean along (m)"]
        assert along.freedom == 0
        slack = 1.5 * (along.hi - along.lo)  # three standard errors on each side
        assert abs(along.mean) < slack
