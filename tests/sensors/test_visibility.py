"""Cameras that see by place: paint on both sides, stop lines, who drives in front."""

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.sensors.visibility import Visibility
from gpsec.types.paint import PaintedLane, paint_file, read_paint, write_paint
from gpsec.types.vehicles import Vehicles

# A straight road of 300 m, a junction at 300 m, and on; a side road makes it one.
NODES = 'id="a" x="0" y="0"\nid="b" x="300" y="0"\nid="c" x="600" y="0"\nid="d" x="300" y="200"'
EDGES = (
    'id="ab" from="a" to="b" speed="13.9"\nid="bc" from="b" to="c" speed="13.9"\nid="db" from="d" to="b" speed="13.9"'
)


@pytest.fixture(scope="module")
def road(plain_net) -> HDMap:
    return compile_map(plain_net(NODES, EDGES), (1.0,))


def end_m(road: HDMap) -> float:
    return float(road.centre_line(road.lane_index["ab_0"])[-1, 0])


def seen(road: HDMap, at_m, stretches=(), threads=1, by_place=True) -> list[bool]:
    """Return whether vehicles of 4.5 m with their rear axle at these places of ab see the lane."""
    table = Table(Vehicles, len(at_m))
    vehicles, rows = table.now, np.arange(len(at_m), dtype=np.int32)
    lane = road.lane_index["ab_0"]
    vehicles.lane[:], vehicles.marked[:] = lane, True
    vehicles.rear_m[:, 0] = at_m
    vehicles.rear_m[:, 1] = road.centre_line(lane)[0, 1]
    run = road.lanes.first[0, lane] + np.arange(road.lanes.segments[0, lane])
    vehicles.segment[:] = run[np.searchsorted(road.lanes.x0_m[run], at_m, side="right") - 1]
    vehicles.axle_m[:] = 3.5
    pool = Threads(threads)
    Visibility.on(road, stretches, np.array([by_place])).limit(rows, vehicles, pool)
    pool.close()
    return vehicles.marked.tolist()


def test_before_a_junction_the_lane_is_lost(road):
    """Nine metres of the way from 6 m on: they end where 15 m are left to the stop line."""
    end = end_m(road)
    for left_m, expected in ((60.0, True), (17.0, True), (13.0, False), (5.0, False)):
        assert seen(road, [end - left_m]) == [expected]


def test_the_cameras_of_other_profiles_see_it_all_the_same(road):
    assert seen(road, [end_m(road) - 5.0], by_place=False) == [True]


def test_a_line_is_needed_on_both_sides(road):
    end = end_m(road)
    assert seen(road, [50.0], [PaintedLane("ab_0", 0.0, end, True, False)]) == [False]
    assert seen(road, [50.0], [PaintedLane("ab_0", 0.0, end, False, True)]) == [False]
    assert seen(road, [50.0], [PaintedLane("ab_0", 0.0, end, True, True)]) == [True]


def test_only_paint_from_6_to_40_m_ahead_counts(road):
    """Nothing is painted from 100 to 150 m."""
    gap = [PaintedLane("ab_0", 100.0, 150.0, False, False)]
    # From 80 m: 86 to 100 m are painted, 14 m. From 90 m: 96 to 100, 4 m. From 115 m: 150 to 155. From 121 m: 11 m.
    for place, expected in ((40.0, True), (80.0, True), (90.0, False), (115.0, False), (121.0, True), (160.0, True)):
        assert seen(road, [place], gap) == [expected], place


def test_who_drives_in_front_hides_it(road):
    """The rear of a vehicle is a metre behind its rear axle: 21 m ahead 14 m are left to see, 12 m ahead 5 m."""
    assert seen(road, [50.0, 71.0]) == [True, True]
    assert seen(road, [50.0, 62.0]) == [False, True]
    assert seen(road, [62.0, 50.0]) == [True, False]


def test_where_lanes_lead_on_without_a_junction_they_are_one(plain_net):
    net = plain_net(
        'id="a" x="0" y="0"\nid="b" x="200" y="0"\nid="c" x="400" y="0"',
        'id="ab" from="a" to="b" speed="13.9"\nid="bc" from="b" to="c" speed="13.9"',
        "--no-internal-links",
    )
    assert seen(compile_map(net, (1.0,)), [190.0]) == [True]


def test_the_same_for_two_threads(road, monkeypatch):
    monkeypatch.setattr(Threads, "MIN_ROWS", 4)
    at_m = np.random.default_rng(1).uniform(0.0, end_m(road), 40)
    assert seen(road, at_m) == seen(road, at_m, threads=2)


def test_lines_are_kept_beside_the_net(tmp_path):
    file = paint_file(tmp_path / "town.net.xml.gz")
    assert file == tmp_path / "town.paint.csv"
    stretches = [PaintedLane("a_0", 0.0, 12.5, True, False), PaintedLane("a_0", 12.5, 30.0, True, True)]
    write_paint(stretches, file)
    assert read_paint(file) == stretches


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("lane,from\n", "expected the columns lane, begin_m, end_m, left, right, found others"),
        ("lane,begin_m,end_m,left,right\na_0,5,1,1,1\n", r"row 2: .* found 'a_0,5,1,1,1'"),
        ("lane,begin_m,end_m,left,right\na_0,0,nan,1,1\n", r"row 2: .* found 'a_0,0,nan,1,1'"),
        ("lane,begin_m,end_m,left,right\na_0,0,1,yes,1\n", "row 2: expected a lane"),
    ],
)
def test_lines_that_are_none_are_refused(tmp_path, text, said):
    (tmp_path / "town.paint.csv").write_text(text)
    with pytest.raises(GpsecError, match=said):
        read_paint(tmp_path / "town.paint.csv")
