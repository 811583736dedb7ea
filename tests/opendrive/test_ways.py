"""Ways of the map beside lanes of the net, and between roads, by hand."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from gpsec.opendrive.extents import extents
from gpsec.opendrive.junctions import along_way, blended, chains
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.netfile import NetLane, net_lanes
from gpsec.opendrive.polylines import at_stations, spread, stations
from gpsec.opendrive.ways import Ways

RADIUS_M = 20.0


def centre(
    points: np.ndarray, section: int = 0, lane: int = -1, next_lane: int | None = None, begin: float = 0.0
) -> CentreLine:
    way = begin + stations(points)
    return CentreLine("7", section, lane, "driving", way, points, way * 0.0, way * 0.0 + 3.5, section + 1, next_lane)


def beside(lines: list[CentreLine], *shapes: list[list[float]]) -> np.ndarray | None:
    """The shape that the first of the lanes of an edge gets, which netconvert has drawn so."""
    lanes = [NetLane(f"e_{at}", "7_-1", False, 3.5, 9.0, np.array(it), Element("lane")) for at, it in enumerate(shapes)]
    found = extents(lanes, Ways(lines))
    return found[0].shape() if 0 in found else None


def quarter() -> np.ndarray:
    """A quarter of a circle to the left, from (0, 0) towards (20, 20)."""
    turn = np.linspace(0.0, 0.5 * np.pi, 64)
    return RADIUS_M * np.stack([np.sin(turn), 1.0 - np.cos(turn)], axis=1)


def straight(y: float, begin: float = 0.0, end: float = 40.0) -> np.ndarray:
    x = np.arange(begin, end + 0.1, 0.5)
    return np.stack([x, np.full_like(x, y)], axis=1)


def net(*edges: str, links: str = "") -> Element:
    return ElementTree.fromstring(f"<net>{''.join(edges)}{links}</net>")


def edge(name: str, shape: str, original: str = "", function: str = "") -> str:
    param = f'<param key="origId" value="{original}"/>' if original else ""
    kind = f' function="{function}"' if function else ""
    return f'<edge id="{name}"{kind}><lane id="{name}_0" index="0" speed="9" shape="{shape}">{param}</lane></edge>'


def junction(*inside: str) -> tuple[Element, list[NetLane]]:
    """A road from the west, one to the north, and lanes from the one to the other, as SUMO links them."""
    names = ["a", *[f":j_{number}" for number in range(len(inside))]]
    vias = [f":j_{number}_0" for number in range(len(inside))]
    links = "".join(
        f'<connection from="{source}" to="b" fromLane="0" toLane="0"' + (f' via="{via}"/>' if via else "/>")
        for source, via in zip(names, [*vias, ""], strict=True)
    )
    middle = [edge(f":j_{number}", shape, "7_-1", "internal") for number, shape in enumerate(inside)]
    root = net(edge("a", "-50,0 0,0"), *middle, edge("b", "20,20 20,70"), links=links)
    return root, net_lanes(root)


def test_spread_keeps_both_ends() -> None:
    points = [np.array([x, 0.0]) for x in (0.0, 0.05, 0.3, 0.95, 1.0)]
    assert spread(points, 0.2)[:, 0].tolist() == [0.0, 0.3, 1.0]


def test_points_at_lengths_along_a_line() -> None:
    line = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 10.0]])
    assert stations(line).tolist() == [0.0, 5.0, 11.0]
    assert at_stations(line, np.array([2.5, 8.0])).tolist() == [[1.5, 2.0], [3.0, 7.0]]


def test_shape_beside_a_way_is_replaced_by_it() -> None:
    found = beside([centre(quarter())], [[0.0, 0.8], [20.8, 20.0]])
    assert found is not None
    assert np.hypot(found[:, 0], found[:, 1] - RADIUS_M) == pytest.approx(RADIUS_M, abs=2e-3)
    assert found[0] == pytest.approx([0.0, 0.0], abs=2e-2)
    assert found[-1] == pytest.approx([20.0, 20.0], abs=2e-2)


def test_lane_that_is_another_one_in_the_next_section() -> None:
    # Number -1 is at y = 0 in the first section; there it becomes -2, and -1 is a lane that opens to its left.
    lines = [
        centre(straight(0.0, 0.0, 40.0), 0, -1, next_lane=-2),
        centre(straight(0.0, 40.0, 80.0), 1, -2, begin=40.0),
        centre(straight(3.5, 40.0, 80.0), 1, -1, begin=40.0),
    ]
    first, second = (beside(lines, [[x, 1.5], [x + 36.0, 1.5]]) for x in (2.0, 42.0))
    assert first is not None
    assert second is not None
    assert np.unique(first[:, 1]).tolist() == [0.0]
    assert np.unique(second[:, 1]).tolist() == [3.5]


@pytest.mark.parametrize("shape", [[[0.0, 30.0], [40.0, 30.0]], [[40.0, 0.0], [0.0, 0.0]]], ids=["far", "backward"])
def test_shape_that_no_way_is_beside(shape: list[list[float]]) -> None:
    assert beside([centre(straight(0.0))], shape) is None


def test_way_between_two_roads_begins_and_ends_with_them() -> None:
    start, end = np.array([-3.0, 0.0]), np.array([20.0, 24.0])
    found = Ways([centre(quarter())]).between("7_-1", start, end)
    assert found is not None
    assert found[0].tolist() == start.tolist()
    assert found[-1].tolist() == end.tolist()
    assert np.hypot(found[1:-1, 0], found[1:-1, 1] - RADIUS_M) == pytest.approx(RADIUS_M, abs=1e-6)


@pytest.mark.parametrize("end", [(23.0, 20.0), (20.0, 50.0)], ids=["beside", "behind"])
def test_way_that_does_not_lead_there(end: tuple[float, float]) -> None:
    assert Ways([centre(quarter())]).between("7_-1", np.zeros(2), np.array(end)) is None


def test_path_of_two_lanes_is_cut_where_they_met() -> None:
    root, lanes = junction("0,0 10,0", "10,0 20,0 20,20")
    chain = next(chains(root, lanes))
    assert [lanes[lane].lane_id for lane in chain.lanes] == [":j_0_0", ":j_1_0"]
    assert chain.before is not None
    assert lanes[chain.before].lane_id == "a_0"
    assert chain.behind is not None
    assert lanes[chain.behind].lane_id == "b_0"
    shapes = along_way(chain, lanes, np.zeros(2), np.array([20.0, 20.0]), Ways([centre(quarter())]))
    first, second = (shapes[lane] for lane in chain.lanes)
    assert first[-1].tolist() == second[0].tolist()
    whole = 0.5 * np.pi * RADIUS_M
    assert stations(first)[-1] == pytest.approx(0.25 * whole, rel=1e-3)  # 10 of 40 m
    assert stations(second)[-1] == pytest.approx(0.75 * whole, rel=1e-3)


def test_path_without_a_way_is_moved_to_its_roads() -> None:
    root, lanes = junction("1,1 11,1")
    chain = next(chains(root, lanes))
    assert along_way(chain, lanes, np.zeros(2), np.array([20.0, 20.0]), Ways([])) == {}
    (shape,) = blended(chain, lanes, np.zeros(2), np.array([12.0, 0.0])).values()
    assert shape.tolist() == [[0.0, 0.0], [12.0, 0.0]]
    (shape,) = blended(chain, lanes, np.zeros(2), np.array([30.0, 0.0])).values()
    assert shape.tolist() == [[0.0, 0.0], [30.0, 0.0]]  # 19 m are too far to bend it
