"""The networks and scenarios in git: rebuilt byte for byte, placed on the earth, and as their descriptions say."""

from __future__ import annotations

import itertools
import math
import subprocess
import sysconfig
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pyproj
import pytest
import sumolib

from sumo_nets import demand
from sumo_nets.alignment import drive, through
from sumo_nets.build import build, main
from sumo_nets.networks import PLANS

ROOT = Path(__file__).parents[2]
NAMES = tuple(PLANS)
EVALUATION = ("slow_curve", "sharp_turns", "town", "highway")
Shape = list[tuple[float, float]]


@cache
def read_net(name: str) -> sumolib.net.Net:
    return sumolib.net.readNet(str(net_path(name)), withInternal=True)


@cache
def read_xml(name: str) -> ElementTree.Element:
    return ElementTree.parse(net_path(name)).getroot()


def net_path(name: str) -> Path:
    return ROOT / "sumo_nets" / name / f"{name}.net.xml"


def lanes(name: str, internal: bool = False) -> list[sumolib.net.lane.Lane]:
    return [lane for edge in read_net(name).getEdges(withInternal=internal) for lane in edge.getLanes()]


def radii(shape: Shape, spacing: float = 4.0) -> list[float]:
    """Radii of the circles through points that lie about `spacing` (m) apart."""
    points = [shape[0]]
    for point in shape[1:]:
        if math.dist(points[-1], point) >= spacing:
            points.append(point)
    result = []
    for a, b, c in zip(points, points[1:], points[2:], strict=False):
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) > 1e-9:
            result.append(math.dist(a, b) * math.dist(b, c) * math.dist(a, c) / (2.0 * abs(area)))
    return result


def net_radii(name: str) -> list[float]:
    return [radius for lane in lanes(name) for radius in radii([point[:2] for point in lane.getShape()])]


@pytest.mark.parametrize("name", NAMES)
def test_rebuilding_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    warnings = build(name, tmp_path)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (net_path(name).parent / path.name).read_bytes(), path.name
    assert not [line for line in warnings if "rror" in line]


def test_check_accepts_what_is_in_git(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check", "slow_curve"]) == 0
    assert capsys.readouterr().err == ""


def test_an_unknown_network_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["twon"]) == 2
    assert "twon" in capsys.readouterr().err


@pytest.mark.parametrize("name", NAMES)
def test_the_scenario_is_what_the_generator_writes(name: str) -> None:
    kept = ROOT / "scenarios" / name / f"{name}.rou.xml"
    assert demand.routes(name, demand.DEMANDS[name]) == kept.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_files_hold_no_dates_and_no_paths(name: str) -> None:
    text = net_path(name).read_text(encoding="utf-8")
    assert "<!--" not in text
    for folder in (net_path(name).parent, ROOT / "scenarios" / name):
        for path in folder.iterdir():
            assert "/home" not in path.read_text(encoding="utf-8")
            assert str(ROOT) not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_projection_puts_the_net_into_central_europe(name: str) -> None:
    net = read_net(name)
    (xmin, ymin), (xmax, ymax) = net.getBBoxXY()
    longitude, latitude = net.convertXY2LonLat(xmin, ymin)
    assert 5.0 < longitude < 18.0
    assert 45.0 < latitude < 55.0
    parameters = read_xml(name).find("location").get("projParameter")
    direct = pyproj.Proj(parameters)(xmin, ymin, inverse=True)
    assert direct == pytest.approx((longitude, latitude), abs=1e-7)
    corner = net.convertXY2LonLat(xmax, ymax)
    _, _, distance = pyproj.Geod(ellps="WGS84").inv(longitude, latitude, *corner)
    assert distance == pytest.approx(math.hypot(xmax - xmin, ymax - ymin), rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_every_lane_has_a_speed_a_width_and_a_length(name: str) -> None:
    for lane in lanes(name, internal=True):
        assert 2.0 < lane.getSpeed() < 37.0, lane.getID()
        assert 2.75 <= lane.getWidth() <= 4.5, lane.getID()
        assert lane.getLength() >= 0.1, lane.getID()
        drawn = sum(math.dist(a, b) for a, b in itertools.pairwise(lane.getShape()))
        assert drawn >= 0.099, lane.getID()
        for kind in ("passenger", "truck", "bus", "delivery"):
            assert lane.allows(kind), lane.getID()


@pytest.mark.parametrize("name", NAMES)
def test_lanes_join_without_a_kink(name: str) -> None:
    shapes = {lane.getID(): lane.getShape() for lane in lanes(name, internal=True)}
    for connection in read_xml(name).iter("connection"):
        if connection.get("via") is None:
            continue
        before = shapes[f"{connection.get('from')}_{connection.get('fromLane')}"]
        after = shapes[connection.get("via")]
        turned = heading(after[0], after[1]) - heading(before[-2], before[-1])
        assert abs(math.remainder(turned, math.tau)) < math.radians(6.0), connection.get("via")
        assert math.dist(before[-1], after[0]) < 0.06, connection.get("via")


def heading(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


@pytest.mark.parametrize("name", EVALUATION)
def test_training_uses_other_roads(name: str) -> None:
    for other in set(NAMES) - set(EVALUATION):
        assert read_xml(name).find("location").get("projParameter") != read_xml(other).find("location").get(
            "projParameter"
        )


def test_slow_curve_turns_slowly_and_has_a_stretch_of_two_lanes() -> None:
    found = net_radii("slow_curve")
    assert 145.0 < min(found) < 200.0
    assert {edge.getLaneNumber() for edge in read_net("slow_curve").getEdges(False)} == {1, 2}


def test_sharp_turns_has_curves_of_12_to_40_m() -> None:
    found = net_radii("sharp_turns")
    assert 9.0 < min(found) < 14.0  # the inner lane of the 12.5 m bend
    for low in (12, 18, 25, 35):
        assert any(low <= radius <= low + 6 for radius in found), low
    assert {edge.getLaneNumber() for edge in read_net("sharp_turns").getEdges(False)} == {1}


def test_highway_has_three_lanes_each_way_ramps_and_clothoids() -> None:
    edges = read_net("highway").getEdges(False)
    for way in ("eastbound", "westbound"):
        main_road = [edge for edge in edges if edge.getName().startswith(way) and "ramp" not in edge.getName()]
        assert {edge.getLaneNumber() for edge in main_road} == {3, 4}
        assert sum(edge.getLength() for edge in main_road) > 8000.0
        assert len({edge.getName() for edge in edges if edge.getName().startswith(f"{way} ramp")}) == 6
    source = ElementTree.parse(net_path("highway").with_name("highway.xodr"))
    assert len(source.findall(".//planView/geometry/spiral")) > 8


def test_town_has_signals_priority_junctions_and_roundabouts() -> None:
    root = read_xml("town")
    kinds = [junction.get("type") for junction in root.iter("junction")]
    assert kinds.count("traffic_light") >= 8
    assert kinds.count("priority") >= 6
    assert len(root.findall("roundabout")) == 2
    assert {edge.getLaneNumber() for edge in read_net("town").getEdges(False)} == {1, 2, 3}


@pytest.mark.parametrize("name", ["town", "suburb"])
def test_the_ring_has_the_right_of_way(name: str) -> None:
    net = read_net(name)
    ring = {edge for roundabout in net.getRoundabouts() for edge in roundabout.getEdges()}
    assert ring
    for edge_id in ring:
        node = net.getEdge(edge_id).getToNode()
        states: set[str] = set()
        for incoming in node.getIncoming():
            if incoming.getFunction() == "internal" or incoming.getID() in ring:
                continue
            states |= {link.getState() for links in incoming.getOutgoing().values() for link in links}
        assert states == {"m"}, edge_id


def test_the_trunk_has_the_right_of_way() -> None:
    checked = 0
    for edge in read_net("slow_curve").getEdges(False):
        if not edge.getName().startswith("side road") or not edge.getToNode().getID().startswith("100"):
            continue
        states = {link.getState() for links in edge.getOutgoing().values() for link in links}
        assert states == {"m"}
        checked += 1
    assert checked == 3


def test_mountain_winds_and_has_one_lane_each_way() -> None:
    found = net_radii("mountain")
    assert 18.0 < min(found) < 25.0
    assert {edge.getLaneNumber() for edge in read_net("mountain").getEdges(False)} == {1}


def test_beltway_has_two_to_four_lanes() -> None:
    edges = [edge for edge in read_net("beltway").getEdges(False) if "ramp" not in edge.getName()]
    assert {2, 3, 4} <= {edge.getLaneNumber() for edge in edges}


@pytest.mark.parametrize("name", NAMES)
def test_sumo_loads_and_runs_the_scenario_without_a_warning(name: str) -> None:
    program = Path(sysconfig.get_path("scripts")) / "sumo"
    configuration = ROOT / "scenarios" / name / f"{name}.sumocfg"
    run = subprocess.run(
        [str(program), "-c", str(configuration), "--end", "10"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""


@pytest.mark.parametrize("name", ["town", "highway"])
def test_attack_zones_lie_on_the_roads(name: str) -> None:
    root = ElementTree.parse(ROOT / "scenarios" / name / f"{name}.add.xml").getroot()
    zones = [zone for zone in root if zone.get("type") == "gpsec.attack"]
    assert {zone.tag for zone in zones} == {"poly", "poi"}
    for zone in zones:
        keys = {param.get("key") for param in zone.iter("param")}
        assert {"gpsec.attack", "gpsec.begin", "gpsec.end", "gpsec.share", "gpsec.bias_m"} <= keys
        if zone.tag == "poi":
            assert "gpsec.radius_m" in keys
            around = read_net(name).getNeighboringEdges(float(zone.get("x")), float(zone.get("y")), 150.0)
            assert around
        else:
            shape = [tuple(map(float, corner.split(","))) for corner in zone.get("shape").split()]
            middles = [lane.getShape()[len(lane.getShape()) // 2] for lane in lanes(name)]
            assert any(sumolib.geomhelper.isWithin(middle[:2], shape) for middle in middles)


def test_an_alignment_through_points_keeps_its_lines_and_its_radius() -> None:
    line = through([(0.0, 0.0), (500.0, 0.0, 100.0), (500.0, 500.0)])
    assert line.end == pytest.approx((500.0, 500.0, math.pi / 2.0), abs=1e-6)
    assert max(abs(segment.k0) for segment in line.segments) == pytest.approx(0.01)


def test_overlapping_curves_are_refused() -> None:
    with pytest.raises(ValueError, match="begins"):
        through([(0.0, 0.0), (100.0, 0.0, 90.0), (100.0, 100.0, 90.0), (0.0, 200.0)])


def test_a_turn_changes_the_heading_by_its_angle() -> None:
    alignment = drive((0.0, 0.0, 0.0), [100.0, (90.0, 30.0), 50.0])
    assert alignment.end[2] == pytest.approx(math.pi / 2.0)
    back = alignment.reversed()
    assert back.end[:2] == pytest.approx((0.0, 0.0), abs=1e-9)
