"""The comparison of net and map, on lanes whose distances are known."""

from xml.etree.ElementTree import Element

import numpy as np
import pytest

from gpsec.opendrive.check import check_lanes
from gpsec.opendrive.compare import match_lanes
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.netfile import NetLane


def line(y: float, backward: bool = False, number: int = -1, width: float = 3.5) -> CentreLine:
    x = np.arange(0.0, 101.0)
    order = slice(None, None, -1) if backward else slice(None)
    heading = np.full(101, np.pi if backward else 0.0)
    points = np.stack([x, np.full(101, y)], axis=1)[order]
    return CentreLine("1", 0, number, "driving", x[order], points, heading, np.full(101, width), 1, None)


def net_lane(points: list[tuple[float, float]], original: str = "1_-1", internal: bool = False) -> NetLane:
    return NetLane("lane", original, internal, 3.5, 10.0, np.array(points), Element("lane"))


@pytest.mark.parametrize(("backward", "sign"), [(False, 1.0), (True, -1.0)])
def test_distance_is_positive_where_the_net_lies_to_the_left(backward: bool, sign: float) -> None:
    ends = [(0.0, 0.4), (100.0, 0.4)]
    found = match_lanes([line(0.0, backward)], [net_lane(ends[::-1] if backward else ends)])
    assert found.matched.all()
    assert found.across_m == pytest.approx(0.4 * sign)


def test_oncoming_lane_is_none() -> None:
    assert not match_lanes([line(0.0)], [net_lane([(100.0, 0.1), (0.0, 0.1)])]).matched.any()


def test_lane_of_another_name_is_none_but_inside_a_junction() -> None:
    beside = [(0.0, 0.5), (100.0, 0.5)]
    assert not match_lanes([line(0.0)], [net_lane(beside, "2_-1")]).matched.any()
    assert match_lanes([line(0.0)], [net_lane(beside, "2_-1", internal=True)]).matched.all()
    too_far = [(0.0, 1.8), (100.0, 1.8)]
    assert not match_lanes([line(0.0)], [net_lane(too_far, "2_-1", internal=True)]).matched.any()


def test_what_lies_beyond_the_end_of_a_lane_is_unmatched() -> None:
    figures = check_lanes([line(0.0)], [net_lane([(0.0, 0.0), (49.9, 0.0)])], {}).overall
    assert figures.points == 101
    assert figures.unmatched_share == pytest.approx(50 / 101)  # 50 m is 0.1 m beyond the end, 51 m is too far


def test_figures_by_hand() -> None:
    # The net drifts from 0 to 1 m to the right: hundredths at every metre.
    check = check_lanes([line(0.0)], [net_lane([(0.0, 0.0), (100.0, -1.0)])], {"sharp": 0.9, "dull": 2.0})
    cos = 100.0 / np.hypot(100.0, 1.0)  # the foot of the perpendicular
    assert check.overall.median_m == pytest.approx(0.5 * cos**2, rel=1e-3)
    assert check.overall.p95_m == pytest.approx(0.95 * cos**2, rel=1e-3)
    assert check.overall.mean_m == pytest.approx(-0.5 * cos**2, rel=1e-2)
    assert check.over_share == {"sharp": pytest.approx(10 / 101, abs=0.011), "dull": 0.0}


def test_narrow_points_are_left_out() -> None:
    lines = [line(0.0), line(-3.0, number=-2, width=1.0)]
    check = check_lanes(lines, [net_lane([(0.0, 0.0), (100.0, 0.0)])], {})
    assert check.narrow_share == pytest.approx(0.5)
    assert check.overall.unmatched_share == 0.0
    assert check.by_lane[1].points == 0
    assert check.by_lane[1].median_m is None
