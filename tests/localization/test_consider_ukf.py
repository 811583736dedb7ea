"""A Schmidt-Kalman filter: what it considers has a variance that no measurement changes."""

import numpy as np
import pytest

from gpsec.filters import learning
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.search import TRACKED
from gpsec.localization import lane_ukf
from gpsec.localization.consider_ukf import correct_considering, update_considering
from gpsec.localization.world import LaneSight, World, make_room
from gpsec.reference.considering import schmidt_update
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES

TABLE = noise_table([RIG_FIGURES])
STATED_M = 0.1
S, SLOW, MOUNTING = learning.LEARNING_STATES, learning.SLOW, learning.MOUNTING


def begin() -> tuple[np.ndarray, np.ndarray]:
    """A state in which everything is correlated with everything, on a lane due east along y = 0."""
    mean = np.zeros(S)
    mean[:3] = 200.0, 0.2, 0.0
    root = np.random.default_rng(2).normal(size=(S, S))
    scale = np.array([0.4, 0.2, 0.02, 0.05, 0.05, 0.01, 1e-3])
    return mean, scale[:, None] * (root @ root.T / S + np.eye(S)) * scale


def see(straight, mean: np.ndarray, covariance: np.ndarray, offset_m: float) -> None:
    world = World(MapView(straight.lanes, straight.index, TRACKED, np.zeros(1, np.int32)), TABLE, STEP_S)
    segment, repairs = correct_considering(
        mean, covariance, -1, make_room(S), world, 0, LaneSight(0, offset_m, 0.0, STATED_M, 10.0, 0.0)
    )
    assert (segment >= 0, repairs) == (True, 0)


def test_the_camera_corrects_the_position_alone(straight):
    mean, covariance = begin()
    # On a straight lane the offset is y, to which the camera's lasting errors add.
    H = np.zeros((1, S))
    H[0, [1, SLOW, MOUNTING]] = 1.0
    R = np.array([[lane_ukf.camera_noise(TABLE, 0, STATED_M)[0] ** 2]])
    expected = schmidt_update(mean, covariance, H, np.array([0.5 - 0.2]), R, active=2)
    considered = covariance[2:, 2:].copy()
    see(straight, mean, covariance, 0.5)
    np.testing.assert_allclose(mean, expected[0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, expected[1], rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(covariance[2:, 2:], considered)
    assert (mean[2:] == 0.0).all()


def test_a_fix_corrects_neither_scale_nor_gyro():
    mean, covariance = begin()
    H = np.zeros((2, S))
    H[[0, 1], [0, 1]] = H[[0, 1], [3, 4]] = 1.0
    nu = np.array([0.3, -0.4]) + H @ np.array([200.0, 0.2, *[0.0] * 5]) - H @ mean
    expected = schmidt_update(mean, covariance, H, nu, 0.01 * np.eye(2), active=5)
    considered = covariance[5:, 5:].copy()
    assert update_considering(mean, covariance, np.zeros(2), 200.3, -0.2, 0.1) == 0
    np.testing.assert_allclose(mean, expected[0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, expected[1], rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(covariance[5:, 5:], considered)


def test_what_lasts_does_not_average_away(straight):
    """After any number of samples the position across is as uncertain as the camera's lasting error."""
    slow = RIG_FIGURES.camera_bias_m**2 + RIG_FIGURES.camera_mount_m**2
    mean, covariance = np.zeros(S), np.zeros((S, S))
    mean[0] = 200.0
    covariance[0, 0] = covariance[1, 1] = 1.0
    covariance[SLOW, SLOW] = slow
    for _ in range(2000):
        see(straight, mean, covariance, 0.1)
    assert mean[1] == pytest.approx(0.1, rel=0.01)
    assert covariance[1, 1] == pytest.approx(slow, rel=0.01)
