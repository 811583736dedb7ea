"""Whether a fix agrees: three standard deviations across the lane and along it, looked at from both sides."""

from math import cos, sin, sqrt

import numpy as np
import pytest

from gpsec.localization.rejoin import SwitchSettings
from gpsec.testing.rig import Rig, rig_figures

# One fix that agrees, without an alarm, is enough.
AT_ONCE = SwitchSettings(hold_s=0.1, rejoin_s=0.1)


def isolated_for(straight, metres: float, response: str) -> Rig:
    """A filter that has trusted GNSS for 2 s and then has driven `metres` without it."""
    rig = Rig(straight, responses=(response,), settings=AT_ONCE, figures=rig_figures(odometer_scale=0.02))
    for _ in range(20):
        rig.step()
    for _ in range(round(metres / (rig.speed_mps * 0.1))):
        rig.step(alarm=True)
    return rig


@pytest.mark.parametrize("response", ["ukf", "ukf5"])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("sigmas", "taken"), [(2.99, True), (3.01, False)])
def test_across_the_lane_it_is_the_residual(straight, response, side, sigmas, taken):
    rig = isolated_for(straight, 20.0, response)
    rig.step(residual_m=side * sigmas * rig.figures.residual_m)
    assert rig.isolated(response) is not taken


def variance_along(rig: Rig, response: str) -> float:
    """Variance along the way of the difference between a fix and the estimate, as it will be in the next step."""
    f, way_m = rig.figures, rig.speed_mps * 0.1
    own = rig.filter(response)
    P, mean = own.covariance, own.mean
    assert abs(mean[2]) < 1e-9  # due east
    along = P[0, 0] + (f.odometer_white_mps * 0.1) ** 2
    if response == "ukf5":
        # Nothing stands in for the scale error: it is a state, as correlated with the position as it has become.
        along += way_m**2 * P[5, 5] - 2.0 * way_m * P[0, 5]
    else:
        along += (f.odometer_scale * rig.speed_mps) ** 2 * 0.1
        along += (f.odometer_scale * (own.isolated_way_m + way_m)) ** 2
    return along + f.gnss_white_m**2 + f.gnss_bias_m**2


@pytest.mark.parametrize("response", ["ukf", "ukf5"])
@pytest.mark.parametrize("metres", [10.0, 200.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("sigmas", "taken"), [(2.97, True), (3.03, False)])
def test_along_the_lane_it_is_the_distance_beyond_a_metre(straight, response, metres, side, sigmas, taken):
    """One metre may have been put into the estimate before the attack was seen."""
    rig = isolated_for(straight, metres, response)
    beyond_m = sigmas * sqrt(variance_along(rig, response))
    error_m = rig.error_m(response)[0, 0]
    rig.step(bias_m=(side * (1.0 + beyond_m) + error_m, 0.0), residual_m=0.0)
    assert rig.isolated(response) is not taken


@pytest.mark.parametrize("response", ["ukf", "ukf5"])
def test_what_was_found_along_the_lane_is_left_to_gnss(straight, response):
    """The variance along the way grows by the square of the distance, and by what the odometer has made of the way."""
    rig = isolated_for(straight, 50.0, response)
    f = rig.figures
    own = variance_along(rig, response) - f.gnss_white_m**2 - f.gnss_bias_m**2
    across = rig.filter(response).covariance[1, 1]
    rig.step(bias_m=(1.2 + rig.error_m(response)[0, 0], 0.0), residual_m=0.0, camera=True)
    assert not rig.isolated(response)
    P = rig.filter(response).covariance
    assert P[0, 0] == pytest.approx(own + 1.2**2, rel=1e-3)
    assert P[1, 1] < across + 0.01
    assert P[3, 3] == P[4, 4] == pytest.approx(f.gnss_bias_m**2)


def test_along_is_the_way_of_the_vehicle(straight):
    """A fix that lies across an estimate that heads north-east is no distance along it."""
    rig = isolated_for(straight, 20.0, "ukf")
    yaw = 0.8
    rig.filter("ukf").mean[2] = yaw
    rig.seen.speed_mps[:] = 0.0
    ahead = np.array([cos(yaw), sin(yaw)])
    across = np.array([-sin(yaw), cos(yaw)])
    rig.speed_mps = 0.0
    offset = rig.filter("ukf").mean[:2] - rig.vehicles.rear_m[0]
    rig.step(bias_m=tuple(offset + 30.0 * ahead), residual_m=0.0, camera=True)
    assert rig.isolated("ukf")
    rig.step(bias_m=tuple(offset + 30.0 * across), residual_m=0.0, camera=True)
    assert not rig.isolated("ukf")
