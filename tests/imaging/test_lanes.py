"""The lane in small pictures whose truth is known by construction."""

from math import atan, degrees

import numpy as np
import pytest

from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.cubic import fit_lane
from gpsec.imaging.pictures.lanes import LaneFinder
from gpsec.imaging.pictures.scene import SeenBodies

from .roads import on_arc, road, view

FINDER = LaneFinder(RoadCamera())


@pytest.mark.parametrize("offset_m", [-0.8, 0.0, 0.35, 1.2])
def test_c0_is_minus_the_offset_at_the_rear_axle(offset_m):
    seen = FINDER.find(view(road(), offset_m), 3.5)
    assert seen.valid
    assert seen.poly[0] == pytest.approx(-offset_m, abs=0.02)
    assert degrees(atan(seen.poly[1])) == pytest.approx(0.0, abs=0.2)
    assert seen.width_m == pytest.approx(3.5, abs=0.03)


def test_c1_is_the_direction_of_the_lane():
    seen = FINDER.find(view(road(), 0.0, turn=0.02), 3.5)
    assert seen.poly[1] == pytest.approx(-0.02, abs=0.003)


@pytest.mark.parametrize("bend", [0.005, -0.01])
def test_c2_is_half_the_curvature(bend):
    seen = FINDER.find(on_arc(road(bend=bend), bend, 0.3), 3.5)
    assert seen.poly[0] == pytest.approx(-0.3, abs=0.05)
    assert seen.poly[2] == pytest.approx(0.5 * bend, rel=0.15)


def test_a_lens_and_another_mounting_are_calibrated_away():
    camera = RoadCamera(distortion=(-0.2, 0.03, 0.0, 0.0, 0.0), pitch_deg=5.0, yaw_deg=2.0, roll_deg=1.0, z_m=1.6)
    seen = LaneFinder(camera).find(view(road(), 0.3, camera=camera), 3.5)
    assert seen.poly[0] == pytest.approx(-0.3, abs=0.03)


def test_without_a_map_the_width_is_found():
    assert FINDER.find(view(road(3.0), 0.2)).width_m == pytest.approx(3.0, abs=0.05)


def test_a_width_that_the_map_denies_is_nothing():
    assert not FINDER.find(view(road(3.0), 0.0), 4.0).valid


def test_a_road_without_paint_says_nothing():
    seen = FINDER.find(view(road(paint=False), 0.0), 3.5)
    assert not seen.valid
    assert not seen.poly.any()


def test_a_leader_close_ahead_hides_the_lane():
    truck = SeenBodies(
        np.array([[19.0, 0.0]]), np.zeros(1), np.full(1, 8.6), np.full(1, 12.0), np.full(1, 6.0), np.ones(1, np.uint64)
    )
    assert not FINDER.find(view(road(), 0.0, others=truck), 3.5).valid


def test_the_same_picture_gives_the_same_lane():
    picture = view(road(), 0.1)
    first, second = FINDER.find(picture, 3.5), LaneFinder(RoadCamera()).find(picture, 3.5)
    np.testing.assert_array_equal(first.poly, second.poly)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("number", [36, 386])  # two of 400 at which it was below zero
def test_marks_at_one_place_never_have_a_variance_below_zero(number):
    x = np.full(3, 6.0 + 0.1 * number)
    left, right = (Marks(x, np.full(3, y), np.ones(3), np.full(3, 0.1)) for y in (1.8, -1.8))
    fit = fit_lane(left, right, np.zeros(4), 3.6, 1.0 / 656.0)
    assert fit is None or np.isfinite(fit.sigma_m)
