import pytest

from gpsec.pipeline.consistency import ISOLATED, TRUSTING, measure_consistency
from gpsec.scenario import load_scenario

# With maps of 2 and 5 m. Of consumer and urban one run says nothing, since their receivers share one error; with many
# seeds they are in docs/localization.md, like all others.
PROFILES = ("carla", "nuscenes")


@pytest.fixture(scope="module", params=PROFILES)
def found(request, repository):
    return measure_consistency(load_scenario(repository / "scenarios" / "sharp_turns"), request.param, 120.0)


def test_filters_that_trust_gnss_are_as_far_off_as_they_say(found, request):
    """The EKF that learns no scale is over-confident along the way where its odometer is good for little: nuscenes."""
    learns = [name for name in TRUSTING if name != "EKF"]
    for name in learns if "nuscenes" in request.node.name else TRUSTING:
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
