"""Curves against closed forms, and against quadrature of their curvature, by hand."""

import numpy as np
import pytest
from scipy.integrate import quad

from gpsec.opendrive.curves import Arc, Line, ParamPoly3, Poly3, ReferenceLineCurve, Spiral


def by_quadrature(start: float, end: float, length: float, s: float) -> tuple[float, float]:
    """The end point of a clothoid: integrals of the cosine and sine of its direction."""

    def turn(at: float) -> float:
        return start * at + 0.5 * (end - start) / length * at * at

    return quad(lambda at: np.cos(turn(at)), 0.0, s)[0], quad(lambda at: np.sin(turn(at)), 0.0, s)[0]


def test_line_leads_straight_on() -> None:
    course = Line().course(np.array([0.0, 7.0]), 10.0)
    assert course.u_m.tolist() == [0.0, 7.0]
    assert course.v_m.tolist() == course.turn_rad.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_quarter_of_a_circle(side: float) -> None:
    course = Arc(side / 20.0).course(np.array([0.0, 10.0 * np.pi]), 40.0)
    assert course.u_m == pytest.approx([0.0, 20.0])
    assert course.v_m == pytest.approx([0.0, side * 20.0])
    assert course.turn_rad == pytest.approx([0.0, side * np.pi / 2.0])


def test_arc_without_curvature_is_a_line() -> None:
    assert Arc(0.0).course(np.array([5.0]), 10.0).u_m == pytest.approx([5.0])


@pytest.mark.parametrize(
    ("start", "end", "length"),
    [
        (0.0, 0.02, 80.0),
        (0.0, -0.02, 80.0),
        (0.05, 0.0, 60.0),
        (-0.03, 0.04, 100.0),
        (0.01, 0.03, 50.0),
        (0.01, 0.0100001, 100.0),
        (0.02, 0.02, 50.0),
    ],
)
def test_clothoid_is_the_integral_of_its_direction(start: float, end: float, length: float) -> None:
    distance = np.array([0.0, 0.3 * length, length])
    course = Spiral(start, end).course(distance, length)
    expected = np.array([by_quadrature(start, end, length, s) for s in distance])
    assert np.stack([course.u_m, course.v_m], axis=1) == pytest.approx(expected, abs=1e-9)
    assert course.turn_rad == pytest.approx(start * distance + 0.5 * (end - start) / length * distance**2)


def test_poly3_is_reached_by_arc_length() -> None:
    # v = u/2 is a straight line that rises by 1 in 2: √5/2 of way for each metre ahead.
    course = Poly3(np.array([0.0, 0.5, 0.0, 0.0])).course(np.array([np.sqrt(5.0)]), 10.0)
    assert (course.u_m[0], course.v_m[0], course.turn_rad[0]) == pytest.approx((2.0, 1.0, np.arctan(0.5)))


def test_poly3_parabola() -> None:
    u = 6.0
    way = quad(lambda at: np.hypot(1.0, 2.0 * 0.05 * at), 0.0, u)[0]
    course = Poly3(np.array([0.0, 0.0, 0.05, 0.0])).course(np.array([way]), 20.0)
    assert (course.u_m[0], course.v_m[0]) == pytest.approx((u, 0.05 * u * u), abs=1e-5)


@pytest.mark.parametrize("end", [1.0, 50.0])
def test_param_poly3_ends_where_its_polynomials_do(end: float) -> None:
    u = np.array([0.0, 50.0, 0.0, -4.0]) / end ** np.arange(4)
    v = np.array([0.0, 0.0, 12.0, -2.0]) / end ** np.arange(4)
    way = quad(lambda p: np.hypot(50.0 - 12.0 * p**2, 24.0 * p - 6.0 * p**2), 0.0, 1.0)[0]
    half = quad(lambda p: np.hypot(50.0 - 12.0 * p**2, 24.0 * p - 6.0 * p**2), 0.0, 0.5)[0]
    course = ParamPoly3(u, v, end).course(np.array([half, way]), way)
    assert course.u_m == pytest.approx([24.5, 46.0], abs=1e-4)
    assert course.v_m == pytest.approx([2.75, 10.0], abs=1e-4)
    assert course.turn_rad == pytest.approx([np.arctan2(10.5, 47.0), np.arctan2(18.0, 38.0)], abs=1e-4)


@pytest.mark.parametrize(
    "curve",
    [Arc(0.03), Spiral(-0.01, 0.04), Poly3(np.array([0.0, 0.1, 0.01, 1e-4]))],
    ids=lambda curve: type(curve).__name__,
)
def test_distance_is_arc_length_and_direction_is_the_way_it_leads(curve: ReferenceLineCurve) -> None:
    course = curve.course(np.linspace(0.0, 30.0, 3001), 30.0)
    du, dv = np.diff(course.u_m), np.diff(course.v_m)
    assert np.hypot(du, dv) == pytest.approx(0.01, rel=1e-3)
    middle = 0.5 * (course.turn_rad[1:] + course.turn_rad[:-1])
    assert np.arctan2(dv, du) == pytest.approx(middle, abs=2e-4)
