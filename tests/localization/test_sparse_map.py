"""What a sparse map leaves open, against roads whose true line is known."""

from math import cos, pi, sin

import numpy as np
import pytest

from gpsec.core.geo import wrap_angle
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView, Pose
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.matching import view_on
from gpsec.hdmap.search import NEAREST, match_nearest
from gpsec.localization.sparse_map import DIRECTION_SHARE, map_variances
from gpsec.localization.world import World
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES

SPACING_M, RADIUS_M = 5.0, 40.0
TABLE = noise_table([RIG_FIGURES])
# So fast that a segment has one sample.
FAST_MPS = 1e3


def pose(way_m: float, bend_m: float) -> tuple[float, float, float]:
    """A straight road due east, and from `bend_m` on a left turn."""
    yaw = max(way_m - bend_m, 0.0) / RADIUS_M
    return min(way_m, bend_m) + RADIUS_M * sin(yaw), RADIUS_M * (1.0 - cos(yaw)), yaw


def road(plain_net, bend_m: float) -> HDMap:
    length = 12 * SPACING_M
    points = [pose(way, bend_m) for way in np.linspace(0.0, length, 1201)]
    shape = " ".join(f"{x:.9f},{y:.9f}" for x, y, _ in points)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{points[-1][0]}" y="{points[-1][1]}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'
    return compile_map(plain_net(nodes, edge), (SPACING_M,))


def world(hd_map: HDMap) -> World:
    return World(MapView(hd_map.lanes, hd_map.index, NEAREST, np.ones(1, np.int32)), TABLE, STEP_S)


def found(hd_map: HDMap, way_m: float, bend_m: float) -> tuple[int, float, float]:
    """Segment, and errors of offset and direction of a vehicle that is on the line."""
    x, y, yaw = pose(way_m, bend_m)
    segment = match_nearest(hd_map.lanes, hd_map.index, Pose(1, 0, x, y, yaw))
    offset, turn = view_on(hd_map.lanes, segment, x, y, yaw, True)
    return segment, offset, wrap_angle(turn)


def test_errors_where_a_turn_begins_are_as_large_as_is_said(plain_net):
    """Over all places between two points where the turn may begin, squares of errors sum up to the variances."""
    errors, said = np.zeros(2), np.zeros(2)
    for bend_m in 25.0 + np.linspace(0.25, 4.75, 10):
        hd_map = road(plain_net, bend_m)
        for way_m in np.arange(12.0, 48.0, 0.25):
            segment, offset, direction = found(hd_map, way_m, bend_m)
            errors += offset**2, direction**2
            said += map_variances(world(hd_map), segment, 0, FAST_MPS)
    assert np.sqrt(said / errors) == pytest.approx(1.0, abs=0.1)


def test_straight_on_and_on_a_circle_nothing_is_open(plain_net):
    hd_map = road(plain_net, 25.0)
    for way_m in (2.5, 12.0, 42.0, 47.0):
        segment, offset, direction = found(hd_map, way_m, 25.0)
        assert map_variances(world(hd_map), segment, 0, FAST_MPS) == pytest.approx((0.0, 0.0), abs=1e-8)
        assert (offset, direction) == pytest.approx((0.0, 0.0), abs=2e-3)


def test_samples_on_one_segment_count_as_one(plain_net):
    """Ten samples a second: five of them share a segment of 5 m at 10 m/s, and all of a vehicle that stands."""
    hd_map = road(plain_net, 25.0)
    segment = found(hd_map, 27.0, 25.0)[0]
    once = np.array(map_variances(world(hd_map), segment, 0, FAST_MPS))
    assert (once > 0.0).all()
    length = hd_map.lanes.length_m[segment]
    for speed, samples in ((10.0, length), (-10.0, length), (2.0, 5.0 * length), (0.0, length / 0.003)):
        many = np.array(map_variances(world(hd_map), segment, 0, speed))
        assert many == pytest.approx(samples * once, rel=1e-9)


def test_half_a_turn_is_no_kink(plain_net):
    """Due west, directions jump from π to -π between the points."""
    shape = " ".join(f"{-x:.6f},{-0.3 * sin(x / 20.0 * pi):.6f}" for x in np.linspace(0.0, 60.0, 600))
    nodes = 'id="a" x="0" y="0"\nid="b" x="-60" y="0"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'
    hd_map = compile_map(plain_net(nodes, edge), (SPACING_M,))
    first, count = hd_map.lanes.first[1, 0], hd_map.lanes.segments[1, 0]
    directions = [map_variances(world(hd_map), s, 0, FAST_MPS)[1] for s in range(first, first + count)]
    assert max(directions) < 0.02**2


def test_at_the_end_of_a_lane_the_curvature_may_end(plain_net):
    """The last segment lies in the turn, and what is behind it the map does not say."""
    hd_map = road(plain_net, 25.0)
    last = hd_map.lanes.first[1, 0] + hd_map.lanes.segments[1, 0] - 1
    turn = hd_map.lanes.turn_rad[last]
    assert turn == pytest.approx(SPACING_M / RADIUS_M, rel=1e-2)
    assert map_variances(world(hd_map), last, 0, FAST_MPS)[1] == pytest.approx((DIRECTION_SHARE * turn) ** 2)
