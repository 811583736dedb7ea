from math import cos, pi, sin, tan

import numpy as np
import pytest

from gpsec.sensors.lane_view import fit_sigmas, lane_polynomial, view_length_m


def test_straight_lane_by_hand():
    # 0.5 m left of a straight lane that points 30° to the left of the vehicle.
    c0, c1, c2, c3 = lane_polynomial(0.5, pi / 6.0, 0.0)
    assert (c0, c1, c2, c3) == pytest.approx((-0.5 / (3.0**0.5 / 2.0), 1.0 / 3.0**0.5, 0.0, 0.0))
    # Its points lie at the signed distance 0.5 m from the vehicle: normal (-sin, cos), foot at -0.5.
    for x in (-3.0, 0.0, 7.0):
        assert -sin(pi / 6.0) * x + cos(pi / 6.0) * (c0 + c1 * x) == pytest.approx(-0.5)


@pytest.mark.parametrize("curvature", [1.0 / 40.0, -1.0 / 40.0])
@pytest.mark.parametrize("turn", [0.0, 0.2, -0.3])
def test_polynomial_is_the_expansion_of_a_circle(curvature, turn):
    # A lane through the origin with direction `turn`: a circle about (-sin, cos)/κ. Its y(x), near the origin:
    centre_x, centre_y = -sin(turn) / curvature, cos(turn) / curvature
    x = np.linspace(-0.4, 0.4, 41)
    y = centre_y - np.copysign(np.sqrt(1.0 / curvature**2 - (x - centre_x) ** 2), curvature)
    fitted = np.polynomial.Polynomial.fit(x, y, 7).convert().coef[:4]
    np.testing.assert_allclose(lane_polynomial(0.0, turn, curvature), fitted, atol=1e-9)


def test_slope_is_the_tangent_of_the_angle_between_lane_and_vehicle():
    assert lane_polynomial(0.0, -0.1, 0.01)[1] == tan(-0.1)


def test_an_arc_leaves_the_view_where_its_bearing_is_half_the_field():
    radius, half_view = 12.0, 0.4
    length = view_length_m(50.0, half_view, -1.0 / radius)
    # The point of a circle of radius R, tangent to the vehicle, after that arc length:
    x, y = radius * sin(length / radius), radius * (1.0 - cos(length / radius))
    assert np.arctan2(y, x) == pytest.approx(half_view)
    assert view_length_m(50.0, half_view, 0.0) == 50.0
    assert view_length_m(50.0, half_view, 1.0 / 300.0) == 50.0


def test_sigmas_are_those_of_a_least_squares_cubic():
    def spread(length):
        x = (np.arange(4000) + 0.5) / 4000.0 * length
        design = np.vander(x, 4, increasing=True)
        # Points of constant density: their number grows with the length.
        return np.sqrt(np.diag(np.linalg.inv(design.T @ design)) * 4000.0 / length)

    full, short = spread(50.0), spread(10.0)
    np.testing.assert_allclose(fit_sigmas(full[0], 50.0, 50.0), full, rtol=1e-3)
    np.testing.assert_allclose(fit_sigmas(full[0], 50.0, 10.0), short, rtol=1e-3)
