from cmath import exp as cexp
from math import cos, degrees, hypot, inf, pi, radians, sin

import numpy as np
import pyproj
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.core.errors import GpsecError
from gpsec.core.geo import DEFAULT_ORIGIN_DEG, Projector, dead_reckon, wrap_angle, yaw_from_sumo_angle

UTM = "+proj=utm +zone=32 +ellps=WGS84 +datum=WGS84 +units=m +no_defs"
angles = st.floats(-100.0, 100.0)


@pytest.mark.parametrize(
    ("angle_deg", "yaw_rad"), [(0.0, pi / 2), (90.0, 0.0), (180.0, -pi / 2), (270.0, -pi), (45.0, pi / 4)]
)
def test_yaw_of_the_compass_points(angle_deg, yaw_rad):
    assert yaw_from_sumo_angle(angle_deg) == pytest.approx(yaw_rad, abs=1e-12)


@given(st.floats(0.0, 360.0))
def test_yaw_points_where_the_sumo_angle_points(angle_deg):
    yaw = yaw_from_sumo_angle(angle_deg)
    assert cos(yaw) == pytest.approx(sin(angle_deg * pi / 180.0), abs=1e-12)
    assert sin(yaw) == pytest.approx(cos(angle_deg * pi / 180.0), abs=1e-12)


@given(st.floats(0.0, 360.0))
def test_yaw_is_wrapped_as_kernels_wrap_it(angle_deg):
    assert yaw_from_sumo_angle(angle_deg) == wrap_angle(radians(90.0 - angle_deg))


@given(angles)
def test_wrapped_angle_is_the_same_direction_in_half_open_range(angle):
    wrapped = wrap_angle(angle)
    assert -pi - 1e-12 <= wrapped < pi + 1e-12
    assert abs(cexp(1j * wrapped) - cexp(1j * angle)) < 1e-12


def test_wrap_angle_at_the_edge():
    assert wrap_angle(pi) == pytest.approx(-pi)
    assert wrap_angle(-pi) == -pi
    assert wrap_angle(0.5) == 0.5


@given(angles, st.floats(-100.0, 100.0), st.floats(-3.0, 3.0))
def test_dead_reckoning_is_exact_on_an_arc(yaw, distance, turn):
    x, y = dead_reckon(10.0, -20.0, yaw, distance, turn)
    if abs(turn) > 1e-5:
        radius = distance / turn
        expected = 10.0 + radius * (sin(yaw + turn) - sin(yaw)), -20.0 - radius * (cos(yaw + turn) - cos(yaw))
    else:
        expected = 10.0 + distance * cos(yaw + turn / 2), -20.0 + distance * sin(yaw + turn / 2)
    assert hypot(x - expected[0], y - expected[1]) < 1e-8


@given(angles, st.floats(0.1, 50.0), st.floats(0.009, 0.03))
def test_dead_reckoning_is_smooth_where_the_series_begins(yaw, distance, turn):
    """Two arcs one after the other are the whole arc, also where one is short and the other is not."""
    x, y = dead_reckon(0.0, 0.0, yaw, distance / 2, turn / 2)
    x, y = dead_reckon(x, y, yaw + turn / 2, distance / 2, turn / 2)
    assert dead_reckon(0.0, 0.0, yaw, distance, turn) == pytest.approx((x, y), abs=1e-11)


def test_utm_net_meets_pyproj():
    projector = Projector(UTM, (-500_000.0, -5_700_000.0), "a.net.xml")
    easting, northing = pyproj.Proj(UTM)(10.0, 51.5)
    net = projector.from_lon_lat(np.array([10.0, 51.5]))
    assert net == pytest.approx([easting - 500_000.0, northing - 5_700_000.0], abs=1e-6)
    assert projector.to_lon_lat(net) == pytest.approx([10.0, 51.5], abs=1e-10)


@pytest.mark.parametrize("definition", [UTM, "!", "-", "."])
def test_round_trip(definition):
    projector = Projector(definition, (-500_000.0, -5_700_000.0) if definition == UTM else (3.0, 4.0))
    there = np.random.default_rng(3).uniform(0.0, 9000.0, (4, 5, 2))
    back = projector.from_lon_lat(projector.to_lon_lat(there))
    assert back.shape == there.shape
    assert abs(back - there).max() < 1e-6


def test_net_without_projection_lies_around_the_default_origin():
    projector = Projector("!", (123.0, 456.0))
    assert not projector.has_projection
    assert projector.to_lon_lat(np.zeros(2)) == pytest.approx(DEFAULT_ORIGIN_DEG, abs=1e-12)
    # 1 km north: a degree of latitude is 111.3 km at 52°.
    north = projector.to_lon_lat(np.array([0.0, 1000.0]))
    assert north[1] - DEFAULT_ORIGIN_DEG[1] == pytest.approx(1.0 / 111.28, rel=1e-3)


@pytest.mark.parametrize("definition", ["+proj=nonsense", "hello", "+lat_0=52 +lon_0=10", ""])
def test_broken_projection_is_one_sentence(definition):
    with pytest.raises(GpsecError, match="is no projection that PROJ knows") as raised:
        Projector(definition, (0.0, 0.0), "town.net.xml").to_lon_lat(np.zeros(2))
    assert str(raised.value).startswith("town.net.xml: ")
    assert "\n" not in str(raised.value)


def test_positions_outside_a_projection_do_not_pass_unseen():
    lon_lat = Projector(UTM).to_lon_lat(np.array([0.0, inf]))
    assert not np.isfinite(lon_lat).all()


def test_degrees_of_a_turn_to_the_left_are_positive():
    x, y = dead_reckon(0.0, 0.0, 0.0, 10.0, pi / 2)
    assert degrees(np.arctan2(y, x)) == pytest.approx(45.0)
