import numpy as np
import pytest

from gpsec.hdmap.map import compile_map

from .nets import BEND, TWO_WAY


def beside(hd_map, lane: str) -> tuple[float, float, float, float]:
    """Same direction left and right, oncoming left and right, of a lane, in metres."""
    at, sides = hd_map.lane_index[lane], hd_map.sides
    columns = (sides.same_left_m, sides.same_right_m, sides.oncoming_left_m, sides.oncoming_right_m)
    return tuple(float(column[at]) for column in columns)  # type: ignore[return-value]


def test_two_way_road(plain_net):
    hd_map = compile_map(plain_net(*TWO_WAY), ())
    assert beside(hd_map, "ab_0") == pytest.approx((3.2, 0.0, 3.2, 0.0))
    assert beside(hd_map, "ab_1") == pytest.approx((0.0, 3.2, 3.2, 0.0))
    assert beside(hd_map, "ba_0") == pytest.approx((0.0, 0.0, 6.4, 0.0))


def test_left_hand_traffic(plain_net):
    hd_map = compile_map(plain_net(*TWO_WAY, "--lefthand"), ())
    assert beside(hd_map, "ab_0") == pytest.approx((0.0, 3.2, 0.0, 3.2))
    assert beside(hd_map, "ab_1") == pytest.approx((3.2, 0.0, 0.0, 3.2))
    assert beside(hd_map, "ba_0") == pytest.approx((0.0, 0.0, 0.0, 6.4))


def test_lanes_of_different_widths_add_up(plain_net):
    nodes = TWO_WAY[0]
    edges = 'id="ab" from="a" to="b" numLanes="3" speed="9" width="3"\nid="ba" from="b" to="a" speed="9" width="4.5"'
    hd_map = compile_map(plain_net(nodes, edges), ())
    assert beside(hd_map, "ab_0") == pytest.approx((6.0, 0.0, 4.5, 0.0))
    assert beside(hd_map, "ab_2") == pytest.approx((0.0, 6.0, 4.5, 0.0))
    assert beside(hd_map, "ba_0") == pytest.approx((0.0, 0.0, 9.0, 0.0))


@pytest.mark.parametrize(("median_m", "oncoming_m"), [(0.0, 6.4), (0.5, 6.4), (6.0, 0.0), (12.0, 0.0)])
def test_a_median_keeps_the_oncoming_traffic_away(plain_net, median_m, oncoming_m):
    half = median_m / 2
    edges = (
        f'id="ab" from="a" to="b" numLanes="2" speed="33" shape="0,{-half} 200,{-half}"\n'
        f'id="ba" from="b" to="a" numLanes="2" speed="33" shape="200,{half} 0,{half}"'
    )
    hd_map = compile_map(plain_net(TWO_WAY[0], edges), ())
    for lane in ("ab_0", "ab_1", "ba_0", "ba_1"):
        assert beside(hd_map, lane)[2:] == pytest.approx((oncoming_m, 0.0)), lane


def test_a_crossing_road_and_internal_lanes_are_no_neighbours(plain_net):
    hd_map = compile_map(plain_net(*BEND), ())
    for lane in hd_map.lane_ids:
        assert beside(hd_map, lane) == (0.0, 0.0, 0.0, 0.0), lane


def test_beside_says_whether_there_is_a_lane_of_either_direction(plain_net):
    hd_map = compile_map(plain_net(*TWO_WAY), ())
    lanes = np.array([hd_map.lane_index[name] for name in ("ab_0", "ab_1", "ba_0")])
    assert hd_map.beside(lanes, left=True).tolist() == [True, True, True]
    assert hd_map.beside(lanes, left=False).tolist() == [False, True, False]
