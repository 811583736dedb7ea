"""What weather does to a picture, and what others hide."""

import numpy as np
import pytest

from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.render import Renderer
from gpsec.imaging.pictures.scene import Moment, SeenBodies
from gpsec.imaging.pictures.weather import WEATHERS

from .roads import NOBODY, road, view


def picture(weather, step=0):
    return Renderer(RoadCamera(), road(), WEATHERS[weather]).picture(Moment(step, np.array([10.0, 0.0]), 0.0, NOBODY))


@pytest.mark.parametrize("weather", WEATHERS)
def test_the_same_moment_is_the_same_picture(weather):
    first = picture(weather)
    assert (first.shape, first.dtype) == ((360, 640, 3), np.uint8)
    np.testing.assert_array_equal(first, picture(weather))


def test_noise_is_another_one_in_the_next_picture():
    assert not np.array_equal(picture("good"), picture("good", step=1))
    np.testing.assert_array_equal(picture("noiseless"), picture("noiseless", step=1))
    rest = picture("good").astype(float) - picture("good", step=1)
    assert rest.std() == pytest.approx(WEATHERS["good"].noise * np.sqrt(2.0), rel=0.1)


def test_paint_stands_out_less_at_night_in_rain_and_worn():
    def contrast(weather):
        red = picture(weather)[:, :, 2].astype(float)
        return np.percentile(red[220:330], 99.5) - np.median(red[220:330])

    assert contrast("good") > contrast("rain") > contrast("rain-night")
    assert contrast("good") > contrast("night") > contrast("rain-night")


def test_a_line_appears_where_the_camera_projects_it():
    camera = RoadCamera()
    red = view(road(), 0.0)[:, :, 2].astype(float)
    at, _ = camera.project(np.array([[10.0, 1.75, 0.0]]))
    row = round(float(at[0, 1]))
    bright = np.flatnonzero(red[row] > 150)
    assert bright[bright < 320].mean() == pytest.approx(at[0, 0], abs=1.5)


def test_a_vehicle_is_drawn_where_it_is_and_hides_the_road():
    ahead = SeenBodies(
        np.array([[30.0, 0.0]]), np.zeros(1), np.full(1, 3.5), np.full(1, 4.5), np.full(1, 1.8), np.ones(1, np.uint64)
    )
    alone, with_it = view(road(), 0.0), view(road(), 0.0, others=ahead)
    changed = np.argwhere((alone != with_it).any(axis=2))
    # Its rear is 19 m ahead of the rear axle: 17.3 m ahead of the camera.
    wide = np.ptp(changed[:, 1])
    assert wide == pytest.approx(1.8 * 656.0 / 17.3, rel=0.1)
    assert changed[:, 1].mean() == pytest.approx(319.5, abs=3.0)
