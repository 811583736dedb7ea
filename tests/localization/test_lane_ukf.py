from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from gpsec.filters.noise import noise_table
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.localization import lane_ukf
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES, Rig, rig_figures

CENTRED = 'spreadType="center"'
BEND_M, RADIUS_M, SPEED_MPS = 60.0, 40.0, 8.0


@pytest.fixture(scope="module")
def winding(plain_net) -> HDMap:
    """60 m due east along y = 0, then a quarter turn to the left of radius 40 m."""
    angles = np.linspace(0.0, pi / 2, 400)
    turn = " ".join(f"{BEND_M + RADIUS_M * sin(a):.9f},{RADIUS_M * (1.0 - cos(a)):.9f}" for a in angles)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{BEND_M + RADIUS_M}" y="{RADIUS_M}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="0,0 {turn}"'
    return compile_map(plain_net(nodes, edge), ())


def pose(way_m: float) -> tuple[float, float, float]:
    yaw = max(way_m - BEND_M, 0.0) / RADIUS_M
    return min(way_m, BEND_M) + RADIUS_M * sin(yaw), RADIUS_M * (1.0 - cos(yaw)), yaw


def test_the_direction_of_the_lane_tells_where_in_a_turn_the_vehicle_is(winding):
    """An estimate 1 m behind sees the lane turn too early. On the straight road nothing tells it."""
    rig = Rig(winding, responses=("ukf", "ukf5"), speed_mps=SPEED_MPS)
    errors = {}
    for step in range(1, 91):
        way = SPEED_MPS * STEP_S * step
        x, y, yaw = pose(way)
        rig.vehicles.rear_m[0] = rig.tracks.fix_m[0] = x, y
        rig.tracks.fix_valid[:] = rig.seen.camera_valid[:] = True
        rig.seen.yaw_rate_rps[:] = (yaw - pose(way - SPEED_MPS * STEP_S)[2]) / STEP_S
        rig.seen.heading_rad[:] = yaw
        rig.alarm[:] = step > 50
        if step == 51:  # 19 m before the bend
            for name in rig.responses:
                rig.filter(name).mean[0] -= 1.0
                rig.filter(name).covariance[0, 0] += 1.0
        rig.localize(rig.rows)
        errors[step] = {name: float(np.hypot(*rig.error_m(name)[0])) for name in rig.responses}
    assert errors[74]["ukf"] == pytest.approx(1.0, abs=0.05)
    assert errors[74]["ukf5"] == pytest.approx(1.0, abs=0.05)
    # 12 m into the turn the lane has turned by 17°.
    assert errors[90]["ukf5"] < 0.5 * errors[90]["ukf"]
    assert errors[90]["ukf5"] < 0.3


def test_between_the_points_of_a_sparse_map_the_lane_is_an_arc(plain_net):
    """Radius 20 m, points every 5 m: chords lie up to 0.16 m inside the lane, and `ukf` believes them."""
    angles = np.linspace(0.0, pi / 2, 600)
    shape = " ".join(f"{20.0 * sin(a):.9f},{20.0 * (1.0 - cos(a)):.9f}" for a in angles)
    nodes = 'id="a" x="0" y="0"\nid="b" x="20" y="20"'
    sparse = compile_map(plain_net(nodes, f'id="ab" from="a" to="b" speed="13.9" shape="{shape}" {CENTRED}'), (5.0,))
    rig = Rig(sparse, responses=("ukf", "ukf5"), speed_mps=4.0)
    rig.world.hd_map.layer[:] = sparse.layer(5.0)
    worst = np.zeros(2)
    for step in range(1, 71):
        yaw = 0.02 * step
        rig.vehicles.rear_m[0] = rig.tracks.fix_m[0] = 20.0 * sin(yaw), 20.0 * (1.0 - cos(yaw))
        rig.tracks.fix_valid[:] = rig.seen.camera_valid[:] = True
        rig.seen.yaw_rate_rps[:], rig.seen.heading_rad[:] = 0.2, yaw
        rig.alarm[:] = step > 5
        rig.localize(rig.rows)
        errors = [np.hypot(*rig.error_m(name)[0]) for name in rig.responses]
        worst = np.maximum(worst, errors)
    assert worst[0] > 0.05
    assert worst[1] < 0.02


def test_a_camera_that_is_off_for_long_is_not_believed_more_and_more(straight):
    """However long it sees the lane, what it sees is off by its slow error: σ does not fall below that."""
    rig = Rig(straight, responses=("ukf", "ukf5"), figures=rig_figures(camera_bias_m=0.06, camera_mount_m=0.05))
    slow = sqrt(0.06**2 + 0.05**2)
    for step in range(600):
        rig.step(alarm=step > 20)
    sigma = np.sqrt([rig.filter(name).covariance[1, 1] for name in rig.responses])
    assert sigma[0] < 0.5 * slow
    assert 0.8 * slow < sigma[1] < 1.1 * slow


def test_white_noise_of_the_camera_by_hand():
    """Half of the view: the white part of C0 grows by √2, that of C1 by √8; the slow parts do not grow."""
    f = RIG_FIGURES
    slow = f.camera_bias_m**2 + f.camera_mount_m**2
    table = noise_table([f])
    for view, offset, slope in ((1.0, 1.0, 1.0), (0.5, sqrt(2.0), sqrt(8.0))):
        stated = sqrt(f.camera_white_m**2 / view + slow)
        found = lane_ukf.camera_noise(table, 0, stated)
        assert found == pytest.approx((offset * f.camera_white_m, slope * f.camera_slope))


def test_a_covariance_that_is_none_is_repaired_and_counted(straight):
    rig = Rig(straight, responses=("ukf5",))
    for _ in range(5):
        rig.step()
    rig.step(alarm=True)
    P = rig.filter("ukf5").covariance
    P[3] = P[:, 3] = 0.0
    P[3, 3] = -0.1
    rig.step(alarm=True)
    assert rig.filter("ukf5").repairs == 1
    assert np.isfinite(rig.filter("ukf5").mean).all()
    assert P[3, 3] == pytest.approx(0.0, abs=1e-12)
