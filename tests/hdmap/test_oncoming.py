"""Where one may turn round, the oncoming lane is part of a lane's chain; who overtakes is on it."""

from math import pi

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import TRACKED
from gpsec.types.vehicles import Vehicles

from .nets import match
from .test_matching import place, residual

# A two-way road towards east, whose ends turn round into each other.
ROUND = (
    'id="a" x="0" y="0"\nid="b" x="400" y="0"',
    'id="ab" from="a" to="b" speed="13.9"\nid="ba" from="b" to="a" speed="13.9"',
)
# Lanes of 3.2 m: their centres lie 1.6 m beside the middle.
OWN_M, ONCOMING_M = -1.6, 1.6


@pytest.fixture(scope="module")
def round_trip(plain_net) -> HDMap:
    return compile_map(plain_net(*ROUND, turnarounds=True), ())


@pytest.fixture(scope="module")
def straight(plain_net) -> HDMap:
    """The same road without a way round."""
    return compile_map(plain_net(*ROUND), ())


def vehicles_at(hd_map: HDMap, lane: str, y_m: float, yaw_rad: float) -> Vehicles:
    """One vehicle in the middle of the road."""
    vehicles = Table(Vehicles, 1).now
    vehicles.lane[:] = hd_map.lane_index[lane]
    vehicles.rear_m[:] = 200.0, y_m
    vehicles.yaw_rad[:] = yaw_rad
    place(hd_map, vehicles)
    return vehicles


def test_the_oncoming_lane_is_in_the_chain(round_trip):
    index, lane = round_trip.index, round_trip.lane_index["ab_0"]
    chain = index.chain_lane[index.chain_first[lane] : index.chain_first[lane] + index.chain_count[lane]]
    assert round_trip.lane_index["ba_0"] in chain


@pytest.mark.parametrize("bias_m", [1.5, 1.7, 3.2, 4.5])
def test_a_bias_across_the_middle_is_not_hidden_by_the_oncoming_lane(round_trip, bias_m):
    """Matched to the oncoming lane, a bias of a lane's width gives no residual."""
    for y_m, yaw_rad, lane in ((OWN_M + bias_m, 0.02, "ab_0"), (ONCOMING_M - bias_m, pi - 0.02, "ba_0")):
        _, found, valid = residual(round_trip, TRACKED, lane, 200.0, y_m, yaw_rad, 0, -1)
        assert valid
        assert found == pytest.approx(-bias_m, rel=1e-3)


def test_no_match_where_nothing_leads_the_vehicles_way(straight):
    assert match(straight, TRACKED, "ab_0", 200.0, OWN_M, pi)[0] == -1


@pytest.mark.parametrize("y_m", [OWN_M + 0.3, 0.5, ONCOMING_M])
def test_a_vehicle_that_swings_out_keeps_its_offset_until_its_lane_changes(round_trip, straight, y_m):
    for hd_map in (round_trip, straight):
        vehicles = vehicles_at(hd_map, "ab_0", y_m, 0.05)
        assert not vehicles.against[0]
        assert vehicles.marked[0]
        assert vehicles.lane_offset_m[0] == pytest.approx(y_m - OWN_M)
        assert vehicles.lane_yaw_rad[0] == pytest.approx(0.0)


@pytest.mark.parametrize("y_m", [OWN_M, -0.2, ONCOMING_M - 0.4, ONCOMING_M + 0.4])
def test_on_the_oncoming_lane_left_and_right_are_the_vehicles(round_trip, straight, y_m):
    """The rear axle follows later than the front, so that it may still be on the side of its own lane."""
    for hd_map in (round_trip, straight):
        vehicles = vehicles_at(hd_map, "ba_0", y_m, -0.05)
        assert vehicles.against[0]
        assert not vehicles.marked[0]
        assert vehicles.lane_offset_m[0] == pytest.approx(y_m - ONCOMING_M)
        assert np.cos(vehicles.lane_yaw_rad[0]) == pytest.approx(1.0)


def test_the_bend_of_an_oncoming_lane_is_to_the_other_side(plain_net):
    """A lane of constant radius that turns left as it is drawn turns right for who meets it."""
    angles = np.linspace(0.0, 1.0, 60)
    points = " ".join(f"{40.0 * np.sin(a):.6f},{40.0 * (1.0 - np.cos(a)):.6f}" for a in angles)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{40.0 * np.sin(1.0):.6f}" y="{40.0 * (1.0 - np.cos(1.0)):.6f}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{points}"'
    bent = compile_map(plain_net(nodes, edge), ())
    vehicles = Table(Vehicles, 2).now
    vehicles.lane[:] = bent.lane_index["ab_0"]
    vehicles.rear_m[:] = 39.0 * np.sin(0.5), 40.0 - 39.0 * np.cos(0.5)
    vehicles.yaw_rad[:] = 0.5, 0.5 + pi
    place(bent, vehicles)
    assert vehicles.against.tolist() == [False, True]
    assert vehicles.camera_curvature_per_m == pytest.approx([1.0 / 40.0, -1.0 / 40.0], rel=1e-2)
    assert vehicles.lane_offset_m == pytest.approx([1.0, -1.0], abs=2e-3)  # chords of 0.7 m
