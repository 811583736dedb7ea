from math import cos, pi, sin

import numpy as np
import pytest
import shapely
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from gpsec.core.tables import Table
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import NEAREST, TRACKED
from gpsec.localization import paper_ukf
from gpsec.localization.responses import CameraUkf
from gpsec.localization.state import Branches
from gpsec.localization.world import World
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

SIGMA_M = 0.08
RADIUS_M = 60.0


@pytest.fixture(scope="module")
def curve(plain_net) -> HDMap:
    """A left turn of radius 60 m about (0, 60), stored at 2 m."""
    angles = np.linspace(0.0, pi / 2, 600)
    shape = " ".join(f"{RADIUS_M * sin(a):.9f},{RADIUS_M * (1.0 - cos(a)):.9f}" for a in angles)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{RADIUS_M}" y="{RADIUS_M}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'
    return compile_map(plain_net(nodes, edge), (2.0,))


def lateral(hd_map: HDMap, layer: int):
    """h(x): signed distance from the stored centre line by shapely, divided by the cosine of Eq 6."""
    points = hd_map.centre_line(0, layer)
    line = shapely.LineString(points)
    first, lanes = hd_map.lanes.first[layer, 0], hd_map.lanes
    start = np.concatenate([[0.0], np.cumsum(lanes.length_m[first : first + lanes.segments[layer, 0]])])

    def h(x: np.ndarray, heading: float) -> np.ndarray:
        point = shapely.Point(x)
        along = line.project(point)
        k = min(int(np.searchsorted(start, along, side="right")) - 1, len(start) - 2)
        segment = first + k
        yaw = lanes.yaw0_rad[segment] + (along - start[k]) / lanes.length_m[segment] * lanes.turn_rad[segment]
        step = points[k + 1] - points[k]
        left = step[0] * (x[1] - points[k, 1]) - step[1] * (x[0] - points[k, 0]) >= 0.0
        return np.array([(1.0 if left else -1.0) * line.distance(point) / cos(heading - yaw)])

    return h


def oracle(hd_map: HDMap, layer: int, x: np.ndarray, P: np.ndarray) -> UnscentedKalmanFilter:
    points = MerweScaledSigmaPoints(n=2, alpha=1.0, beta=2.0, kappa=1.0)
    filter_ = UnscentedKalmanFilter(
        dim_x=2, dim_z=1, dt=STEP_S, hx=lateral(hd_map, layer), fx=lambda x, dt, move: x + move, points=points
    )
    filter_.x, filter_.P, filter_.R = x.copy(), P.copy(), np.array([[SIGMA_M**2]])
    return filter_


def test_weights_are_those_of_filterpy():
    points = MerweScaledSigmaPoints(n=2, alpha=paper_ukf.ALPHA, beta=paper_ukf.BETA, kappa=paper_ukf.KAPPA)
    np.testing.assert_array_equal(np.array(paper_ukf.MEAN_WEIGHTS), points.Wm, strict=True)
    np.testing.assert_array_equal(np.array(paper_ukf.COVARIANCE_WEIGHTS), points.Wc, strict=True)
    assert paper_ukf.SPREAD == 3.0


def noise_of_a_step(speed: float, middle: float, yaw_variance: float) -> np.ndarray:
    """Additive process noise, along and across the body."""
    f, lasting = RIG_FIGURES, STEP_S * 1.0
    along = (f.odometer_white_mps * STEP_S) ** 2 + (f.odometer_scale * speed) ** 2 * lasting
    across = yaw_variance * speed**2 * lasting
    turned = np.array([[cos(middle), -sin(middle)], [sin(middle), cos(middle)]])
    return turned @ np.diag([along, across]) @ turned.T


def start(x: float, y: float, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    mean, P = np.array([x, y, yaw, 0.0, 0.0]), np.zeros((5, 5))
    P[:2, :2] = [[0.05, 0.01], [0.01, 0.03]]
    P[2, 2] = 0.01**2
    return mean, P


def correct(
    hd_map: HDMap, mode: int, layer: int, mean: np.ndarray, P: np.ndarray, hint: int, offset_m: float
) -> tuple[int, int]:
    """Correct `mean` and `P` in place with one lane offset; return the segment and the repairs made."""
    view = MapView(hd_map.lanes, hd_map.index, mode, np.array([layer], np.int32))
    world = World(view, noise_table([RIG_FIGURES]), STEP_S)
    branches = Table(Branches, states=5, snapshots=0, triangle=15).now
    tracks, vehicles, seen = Table(Tracks).now, Table(Vehicles).now, Table(Measurements).now
    branches.mean[0], branches.covariance[0], branches.segment[:] = mean, P, hint
    branches.track[:] = tracks.vehicle[:] = tracks.lane[:] = 0
    tracks.lane_known[:] = True
    seen.lane_poly[0, 0], seen.camera_sigma_m[:], seen.camera_valid[:] = -offset_m, SIGMA_M, True
    CameraUkf().correct(np.zeros(1, np.int32), branches, tracks, vehicles, seen, world)
    mean[:], P[:] = branches.mean[0], branches.covariance[0]
    return int(branches.segment[0]), int(branches.repairs[0])


def follow(hd_map: HDMap, layer: int, mean: np.ndarray, P: np.ndarray, yaw_rate: float, steps: int, mode: int) -> None:
    """Run both filters side by side and compare them after every half-step."""
    rng = np.random.default_rng(5)
    table, hint = noise_table([RIG_FIGURES]), -1
    other = oracle(hd_map, layer, mean[:2], P[:2, :2])
    for _ in range(steps):
        speed = 8.0 + rng.normal(0.0, 0.05)
        rate = yaw_rate + rng.normal(0.0, 0.01)
        yaw, yaw_variance = mean[2], P[2, 2]
        paper_ukf.predict_position(mean, P, table, 0, speed, rate, STEP_S)
        turn = rate * STEP_S
        move = speed / rate * np.array([sin(yaw + turn) - sin(yaw), cos(yaw) - cos(yaw + turn)])
        other.Q = noise_of_a_step(speed, yaw + turn / 2, yaw_variance)
        other.predict(move=move)
        assert mean[:2] == pytest.approx(other.x, abs=1e-9)
        assert P[:2, :2] == pytest.approx(other.P, abs=1e-9)
        seen = float(other.hx(other.x, mean[2])[0] + rng.normal(0.0, SIGMA_M))
        hint, repairs = correct(hd_map, mode, layer, mean, P, hint, seen)
        other.update(np.array([seen]), heading=mean[2])
        assert (hint >= 0, repairs) == (True, 0)
        assert mean[:2] == pytest.approx(other.x, abs=1e-9)
        assert P[:2, :2] == pytest.approx(other.P, abs=1e-9)
        assert np.linalg.eigvalsh(P[:2, :2]).min() > 0.0


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
@pytest.mark.parametrize("yaw", [0.0, 0.2])
def test_filterpy_on_a_straight_lane(straight, yaw, mode):
    follow(straight, 0, *start(100.0, 0.4, yaw), yaw_rate=0.001, steps=60, mode=mode)


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
@pytest.mark.parametrize("layer", [0, 1])
def test_filterpy_on_a_curve(curve, layer, mode):
    angle = 0.15
    at = (RADIUS_M - 0.5) * sin(angle), RADIUS_M - (RADIUS_M - 0.5) * cos(angle)
    follow(curve, layer, *start(*at, angle), yaw_rate=8.0 / RADIUS_M, steps=80, mode=mode)


def test_the_camera_takes_the_error_across_the_lane_away_and_leaves_that_along_it(straight):
    """On a straight lane h is linear: P_yy shrinks as a scalar Kalman filter's, P_xx stays."""
    mean, P = start(100.0, 0.6, 0.0)
    P[:2, :2] = np.diag([0.5, 0.2])
    correct(straight, TRACKED, 0, mean, P, -1, 0.1)
    gain = 0.2 / (0.2 + SIGMA_M**2)
    assert mean[:2] == pytest.approx([100.0, 0.6 + gain * (0.1 - 0.6)], abs=1e-12)
    assert P[:2, :2] == pytest.approx(np.diag([0.5, (1.0 - gain) * 0.2]), abs=1e-12)


def test_nothing_is_corrected_where_a_sigma_point_has_no_match(straight):
    mean, P = start(100.0, 0.6, 1.2)  # 69° off the lane
    before = mean.copy(), P.copy()
    assert correct(straight, TRACKED, 0, mean, P, 0, 0.1) == (-1, 0)
    assert (mean.tobytes(), P.tobytes()) == (before[0].tobytes(), before[1].tobytes())


@pytest.mark.parametrize("broken", [[[-0.1, 0.0], [0.0, 0.1]], [[0.1, 0.2], [0.2, 0.1]], [[0.0, 0.0], [0.0, 0.0]]])
def test_a_covariance_that_is_none_is_repaired_and_counted(straight, broken):
    mean, P = start(100.0, 0.6, 0.0)
    P[:2, :2] = broken
    _, repairs = correct(straight, TRACKED, 0, mean, P, -1, 0.1)
    assert repairs == 1
    assert np.isfinite(mean).all()
    assert np.linalg.eigvalsh(P[:2, :2]).min() > 0.0
