"""The UKF of `ukf5` with filterpy's sigma points, and the lane as one writes it down by hand: a line, and a circle."""

from collections.abc import Callable
from math import atan2, cos, exp, hypot, pi, sin, sqrt, tan

import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints, unscented_transform

from gpsec.filters import learning
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import NEAREST, TRACKED
from gpsec.localization import lane_ukf
from gpsec.localization.learning import LEARNING_EKF
from gpsec.localization.world import LaneSight, World, make_room
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES

# East, north, yaw, scale error of the odometer, gyro bias, slow error and mounting of the camera in a filter's state.
AT = [0, 1, 2, learning.SCALE, learning.GYRO_ERROR, learning.SLOW, learning.MOUNTING]
STATED_M = 0.1
TABLE = noise_table([RIG_FIGURES])
RADIUS_M = 50.0

View = Callable[[np.ndarray], np.ndarray]


def on_the_line(state: np.ndarray) -> np.ndarray:
    """Offset (Eq 6) and slope of a lane due east along y = 0."""
    _, y, yaw = state[:3]
    return np.array([y / cos(yaw), tan(-yaw)])


def on_the_circle(state: np.ndarray) -> np.ndarray:
    """The same of a left turn about (0, 50)."""
    x, y, yaw = state[:3]
    turn = atan2(x, RADIUS_M - y) - yaw
    return np.array([(RADIUS_M - hypot(x, RADIUS_M - y)) / cos(turn), tan(turn)])


@pytest.fixture(scope="module")
def circle(plain_net) -> HDMap:
    angles = np.linspace(0.0, pi / 2, 3000)
    shape = " ".join(f"{RADIUS_M * sin(a):.9f},{RADIUS_M * (1.0 - cos(a)):.9f}" for a in angles)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{RADIUS_M}" y="{RADIUS_M}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'
    return compile_map(plain_net(nodes, edge), ())


def begin(x: float, y: float, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """A state in which every active one is uncertain, off zero and correlated with the others."""
    mean = np.zeros(learning.LEARNING_STATES)
    mean[AT] = x, y, yaw, 0.01, -2e-3, 0.08, -0.03
    root = np.random.default_rng(2).normal(size=(7, 7))
    scale = np.array([0.4, 0.2, 0.02, 0.01, 1e-3, 0.05, 0.04])
    covariance = np.zeros((learning.LEARNING_STATES,) * 2)
    correlated = root @ root.T / 7.0 + np.eye(7)
    covariance[np.ix_(AT, AT)] = scale[:, None] * correlated * scale
    return mean, covariance


def noise_of_camera() -> np.ndarray:
    """Covariance of -C0 and C1."""
    white, slope = lane_ukf.camera_noise(TABLE, 0, STATED_M)
    both = -RIG_FIGURES.camera_slope_correlation * white * slope
    return np.array([[white**2, both], [both, slope**2]])


def filterpys(mean: np.ndarray, covariance: np.ndarray, view: View, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance after an update: joint moments of all states and of what they see, of filterpy's points."""
    points = MerweScaledSigmaPoints(n=3, alpha=1.0, beta=2.0, kappa=0.0)
    x, P = mean[AT], covariance[np.ix_(AT, AT)]
    sigmas = points.sigma_points(x[:3], P[:3, :3])
    views = np.array([view(point) for point in sigmas])
    expected, spread = unscented_transform(views, points.Wm, points.Wc)
    # All other states go with position and yaw by regression, and the camera's errors add to the offset.
    cross = P[:, :3] @ np.linalg.inv(P[:3, :3]) @ ((sigmas - x[:3]).T @ (points.Wc[:, None] * (views - expected)))
    camera = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0], [0.0] * 7])
    S = spread + camera @ cross + cross.T @ camera.T + camera @ P @ camera.T + noise_of_camera()
    gain = (cross + P @ camera.T) @ np.linalg.inv(S)
    return x + gain @ (seen - expected - camera @ x), P - gain @ S @ gain.T


def corrected(
    hd_map: HDMap, mode: int, mean: np.ndarray, covariance: np.ndarray, hint: int, seen: np.ndarray
) -> tuple[int, int]:
    """Correct in place with an offset and a slope; return the segment and the repairs made."""
    world = World(MapView(hd_map.lanes, hd_map.index, mode, np.zeros(1, np.int32)), TABLE, STEP_S)
    sight = LaneSight(0, float(seen[0]), float(seen[1]), STATED_M, 10.0, 0.0)
    return lane_ukf.correct_by_lane(mean, covariance, hint, make_room(learning.LEARNING_STATES), world, 0, sight)


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
@pytest.mark.parametrize("off", [(0.3, 0.05), (-0.3, -0.05)])
@pytest.mark.parametrize("turning", [False, True])
def test_every_state_is_corrected_as_filterpy_does(straight, circle, mode, off, turning):
    hd_map, view = (circle, on_the_circle) if turning else (straight, on_the_line)
    angle = 0.6
    at = (RADIUS_M * sin(angle), RADIUS_M * (1.0 - cos(angle)), angle) if turning else (200.0, 0.4, 0.1)
    mean, covariance = begin(*at)
    hint = -1
    for _ in range(5):
        seen = view(mean[AT]) + np.array(off)
        wanted, spread = filterpys(mean, covariance, view, seen)
        before = mean.copy()
        hint, repairs = corrected(hd_map, mode, mean, covariance, hint, seen)
        assert (hint >= 0, repairs) == (True, 0)
        # The circle of the map has chords of 2.6 cm.
        np.testing.assert_allclose(mean[AT], wanted, rtol=0.0, atol=5e-4 if turning else 1e-9)
        np.testing.assert_allclose(covariance[np.ix_(AT, AT)], spread, rtol=0.0, atol=5e-5 if turning else 1e-9)
        assert (np.abs(mean[AT] - before[AT]) > 0.0).all()


def test_the_cameras_mounting_stays_and_its_bias_fades():
    """Each has its own state: after a long time the bias is as unknown as at first, and the mounting is as it was."""
    f = RIG_FIGURES
    mean, covariance = begin(0.0, 0.0, 0.0)
    covariance[learning.SLOW, learning.SLOW] = 1e-4
    mount = covariance[learning.MOUNTING, learning.MOUNTING]
    steps = 1000
    for _ in range(steps):
        LEARNING_EKF.predict(mean, covariance, TABLE, 0, 10.0, 0.0, STEP_S, True)
    decay = exp(-steps * STEP_S / f.camera_bias_tau_s)
    left = f.camera_bias_m**2 * (1.0 - decay**2) + 1e-4 * decay**2
    assert mean[learning.SLOW] == pytest.approx(0.08 * decay, rel=1e-9)
    assert covariance[learning.SLOW, learning.SLOW] == pytest.approx(left, rel=1e-9)
    assert (mean[learning.MOUNTING], covariance[learning.MOUNTING, learning.MOUNTING]) == (-0.03, mount)


def test_what_a_lasting_offset_shows_is_shared_by_its_variance(straight):
    """On a straight lane the filter cannot tell a camera that is off from a vehicle that is: each takes its share."""
    mean, covariance = np.zeros(learning.LEARNING_STATES), np.zeros((learning.LEARNING_STATES,) * 2)
    mean[0] = 200.0
    across, slow, white = 0.09, 0.0025, lane_ukf.camera_noise(TABLE, 0, STATED_M)[0] ** 2
    # That the slope is as expected tells of the offset's white error, which goes with it.
    white *= 1.0 - RIG_FIGURES.camera_slope_correlation**2
    covariance[0, 0] = 1.0
    covariance[1, 1], covariance[learning.SLOW, learning.SLOW] = across, slow
    corrected(straight, TRACKED, mean, covariance, -1, np.array([0.2, 0.0]))
    total = across + slow + white
    assert mean[1] == pytest.approx(0.2 * across / total, rel=1e-6)
    assert mean[learning.SLOW] == pytest.approx(0.2 * slow / total, rel=1e-6)
    assert sqrt(covariance[1, 1]) == pytest.approx(sqrt(across - across**2 / total), rel=1e-6)
    assert covariance[1, learning.SLOW] == pytest.approx(-across * slow / total, rel=1e-6)
