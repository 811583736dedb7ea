"""Maps in a mirror."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec.opendrive.lanes import centre_lines
from gpsec.opendrive.lefthand import map_keeps_left, mirror_map, mirror_net
from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.spelling import spell_out

from .maps import TWO_WAY, document, lane, road, section, write

CURVES = {
    "arc": '<arc curvature="0.02"/>',
    "spiral": '<spiral curvStart="-0.01" curvEnd="0.03"/>',
    "poly3": '<poly3 a="0.5" b="0.1" c="0.002" d="-1e-5"/>',
    "paramPoly3": '<paramPoly3 aU="0" bU="60" cU="1" dU="-2" aV="1" bV="3" cV="9" dV="-2" pRange="normalized"/>',
}


def test_side_of_traffic_is_that_of_most_roads(tmp_path: Path) -> None:
    long, short = road(TWO_WAY, rule="LHT"), road(TWO_WAY, length=20.0, number="2")
    path = write(tmp_path, document(long, short))
    assert map_keeps_left(roads(parse(path), path))
    path = write(tmp_path, document(road(TWO_WAY)))
    assert not map_keeps_left(roads(parse(path), path))


@pytest.mark.parametrize("curve", CURVES)
def test_lanes_are_where_a_mirror_shows_them(curve: str, tmp_path: Path) -> None:
    border = '<border sOffset="0" a="-7" b="-0.01" c="0" d="0"/>'
    written = road(
        section(lane(1, 3.0), lane(-1, 4.0) + lane(-2, border)),
        f'<geometry s="0" x="10" y="20" hdg="0.7" length="60">{CURVES[curve]}</geometry>',
        60.0,
        offset='<laneOffset s="0" a="0.4" b="0.01" c="0" d="0"/>',
        lateral='<superelevation s="0" a="0.05" b="0" c="0" d="0"/>',
    )
    path = write(tmp_path, document(written))
    root = parse(path)
    spell_out(root)
    before = {line.lane_id: line for line in centre_lines(roads(root, path), 1.0)}
    mirror_map(root)
    after = {line.lane_id: line for line in centre_lines(roads(root, path), 1.0)}
    assert set(after) == {-1, 1, 2}
    for number, line in before.items():
        # A lane on the other side is driven the other way.
        assert after[-number].points_m[::-1] * [1, -1] == pytest.approx(line.points_m)
        assert after[-number].width_m[::-1] == pytest.approx(line.width_m)


def test_links_and_signals_are_changed_over(tmp_path: Path) -> None:
    inside = '<link><predecessor id="-2"/><successor id="-1"/></link>'
    path = write(tmp_path, document(road(section(lane(1, 3.0), lane(-1, 4.0, inside=inside)))))
    root = parse(path)
    road_element = root.find("road")
    assert road_element is not None
    road_element.append(ElementTree.fromstring('<signal t="-5"><validity fromLane="-3" toLane="-1"/></signal>'))
    mirror_map(root)
    left = root.find("road/lanes/laneSection/left/lane")
    assert left is not None
    assert left.get("id") == "1"
    assert [item.get("id") for item in left.iterfind("link/*")] == ["2", "1"]
    assert [item.get("id") for item in root.iterfind("road/lanes/laneSection/right/lane")] == ["-1"]
    validity = root.find("road/signal/validity")
    assert validity is not None
    assert validity.attrib == {"fromLane": "1", "toLane": "3"}


def test_net_is_mirrored_back() -> None:
    net = ElementTree.fromstring(
        '<net><location convBoundary="1,-7,3,5"/><edge id="a"><lane id="a_0" shape="1,2.5 3,-4.0,9">'
        '<param key="origId" value="r_1_-2"/></lane></edge><junction id="j" x="1" y="2" shape="0,1 1,0"/>'
        '<connection from="a" to="b" dir="l"/><connection from="a" to="c" dir="s"/></net>'
    )
    mirror_net(net)
    assert net.get("lefthand") == "true"
    assert [item.get("shape") for item in net.iter() if item.get("shape")] == ["1,-2.5 3,4.0,9", "0,-1 1,-0"]
    assert net.find("junction").get("y") == "-2.0000"  # type: ignore[union-attr]
    assert [item.get("dir") for item in net.iterfind("connection")] == ["r", "s"]
    assert net.find("edge/lane/param").get("value") == "r_1_2"  # type: ignore[union-attr]
    boundary = net.find("location").get("convBoundary", "")  # type: ignore[union-attr]
    assert np.array(boundary.split(","), float).tolist() == [1.0, -5.0, 3.0, 7.0]
