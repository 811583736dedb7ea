"""The lane at the axle, where the road begins or ends to bend between it and the marks."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.cubic import LineFit, fit_lane

WIDTH_M, PIXEL_RAD = 3.5, 1.0 / 656.0
RADIUS_M = 37.0


def arc_from(place_m: float, x_m: Floats) -> Floats:
    """Return the y (m) of a lane that is straight up to a place, and an arc of 37 m from there on."""
    ahead = np.maximum(x_m - place_m, 0.0)
    return RADIUS_M - np.sqrt(RADIUS_M**2 - ahead**2)


def arc_up_to(place_m: float, x_m: Floats) -> Floats:
    """Return the y (m) of a lane that is an arc of 37 m up to a place, as seen along it, and straight from there on."""
    at = RADIUS_M - np.sqrt(RADIUS_M**2 - np.minimum(x_m, place_m) ** 2)
    slope = place_m / np.sqrt(RADIUS_M**2 - place_m**2)
    return at + slope * np.maximum(x_m - place_m, 0.0)


def spiral(x_m: Floats) -> Floats:
    """Return the y (m) of a lane whose curvature grows evenly to 1/50 m 30 m ahead."""
    return x_m**3 / (6.0 * 50.0 * 30.0)


def fitted(centre: Callable[[Floats], Floats], bend: float, seed: int = 1) -> LineFit:
    """Return the fit to marks of both lines of a lane from 6.5 m to 24 m ahead, with noise."""
    rng = np.random.default_rng(seed)
    x = np.arange(6.5, 24.0, 0.1)
    slope = np.gradient(centre(x), x)
    normal = np.stack([-slope, np.ones_like(x)]) / np.hypot(slope, 1.0)
    sides = []
    for side in (0.5, -0.5):
        place = np.stack([x, centre(x)]) + side * WIDTH_M * normal
        noise = 0.02 * rng.standard_normal(len(x))
        sides.append(Marks(place[0], place[1] + noise, np.ones(len(x)), np.full(len(x), 0.1)))
    fit = fit_lane(*sides, np.array([0.0, 0.0, bend, 0.0]), WIDTH_M, PIXEL_RAD)
    assert fit is not None
    return fit


@pytest.mark.parametrize(
    "centre",
    [partial(arc_from, place_m) for place_m in (8.0, 10.0, 11.0, 13.0, 16.0)]
    + [partial(arc_up_to, place_m) for place_m in (8.0, 10.0, 11.0, 13.0, 16.0)],
)
def test_c0_is_right_where_a_sharp_bend_begins_or_ends_ahead(centre):
    """A cubic through the same marks is off by up to 0.8 m, with a stated deviation of 0.1 m."""
    fit = fitted(centre, 0.01)
    assert abs(fit.poly[0]) < min(0.25, 2.0 * fit.sigma_m)


def test_what_marks_cannot_tell_is_stated():
    """Where the bend begins nearer than the first marks, it may as well have begun before the axle."""
    straight = fitted(np.zeros_like, 0.0)
    unsure = fitted(partial(arc_from, 5.0), 0.012)
    assert straight.sigma_m < 0.05
    assert unsure.sigma_m > 0.15
    assert abs(unsure.poly[0]) < 2.0 * unsure.sigma_m


def test_a_bend_that_grows_evenly_is_found_too():
    fit = fitted(spiral, 0.005)
    assert abs(fit.poly[0]) < min(0.15, 2.0 * fit.sigma_m)


def test_a_gentle_bend_is_a_cubic():
    """The curvature of a road of 400 m radius is that of the cubic, with its small standard deviation."""
    fit = fitted(lambda x_m: x_m**2 / 800.0, 0.00125)
    assert fit.sigma_m < 0.1
    assert fit.poly[2] == pytest.approx(1.0 / 800.0, rel=0.25)
