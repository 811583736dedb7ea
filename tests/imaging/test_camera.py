"""Points and pixels: by hand, there and back."""

from math import tan

import numpy as np
import pytest

from gpsec.imaging.pictures.camera import RoadCamera

LENS = (-0.26, 0.05, -7e-4, 2e-4, -0.01)


def test_a_point_straight_ahead_is_in_the_middle():
    camera = RoadCamera(pitch_deg=0.0)
    pixels, depth = camera.project(np.array([[11.7, 0.0, 1.3], [11.7, 1.0, 1.3], [11.7, 0.0, 0.0]]))
    np.testing.assert_allclose(depth, 10.0)
    np.testing.assert_allclose(pixels, [[319.5, 179.5], [319.5 - 65.6, 179.5], [319.5, 179.5 + 0.13 * 656.0]])


def test_looking_down_moves_the_horizon_up_and_left_moves_it_right():
    far = np.array([[1e9, 0.0, 0.0]])
    pixels, _ = RoadCamera(pitch_deg=3.0, yaw_deg=2.0).project(far)
    assert pixels[0, 1] == pytest.approx(179.5 - 656.0 * tan(np.radians(3.0)), abs=0.2)
    assert pixels[0, 0] == pytest.approx(319.5 + 656.0 * tan(np.radians(2.0)), abs=1.0)


def test_with_the_right_side_down_what_is_right_appears_higher():
    pixels, _ = RoadCamera(roll_deg=5.0).project(np.array([[20.0, -5.0, 0.0], [20.0, 5.0, 0.0]]))
    assert pixels[0, 1] < pixels[1, 1]


@pytest.mark.parametrize("distortion", [(0.0,) * 5, LENS])
def test_the_road_at_a_pixel_appears_at_that_pixel(distortion):
    camera = RoadCamera(distortion=distortion, roll_deg=1.0, yaw_deg=-2.0)
    wanted = np.array([[100.0, 300.0], [320.0, 200.0], [600.0, 350.0]])
    ground = camera.on_road(wanted)
    pixels, _ = camera.project(np.column_stack([ground, np.zeros(3)]))
    np.testing.assert_allclose(pixels, wanted, atol=0.02)


def test_there_is_no_road_over_the_horizon():
    assert np.isinf(RoadCamera().on_road(np.array([[319.0, 10.0]]))).all()


def test_a_resized_picture_shows_the_same_point_at_the_same_share():
    camera = RoadCamera(width=1280, height=720, fx=1300.0, fy=1310.0, cx=650.0, cy=350.0, distortion=LENS)
    point = np.array([[15.0, 2.0, 0.0]])
    large, small = camera.project(point)[0], camera.scaled(640).project(point)[0]
    np.testing.assert_allclose((large + 0.5) / 2.0, small + 0.5, atol=1e-9)
