"""Names of roads that SUMO does not take are changed for netconvert alone."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from gpsec.opendrive.importing import import_map
from gpsec.opendrive.names import rename_for_netconvert, restore_names
from gpsec.opendrive.netfile import net_lanes
from gpsec.opendrive.read import parse

from .maps import LINE, TWO_WAY, document, road, write


def link(which: str, kind: str, name: str) -> str:
    return f'<link><{which} elementType="{kind}" elementId="{name}" contactPoint="start"/></link>'


def test_whatever_points_to_a_renamed_road_follows(tmp_path: Path) -> None:
    first = road(TWO_WAY, number="a b").replace("<planView>", link("successor", "junction", "x y") + "<planView>")
    inner = road(TWO_WAY, number="{7}").replace('junction="-1"', 'junction="x y"')
    inner = inner.replace("<planView>", link("predecessor", "road", "a b") + "<planView>")
    way = '<connection id="0" incomingRoad="a b" connectingRoad="{7}" contactPoint="start"/>'
    crossing = f'<junction id="x y">{way}</junction>'
    root = parse(write(tmp_path, document(first, inner).replace("</OpenDRIVE>", f"{crossing}</OpenDRIVE>")))
    assert rename_for_netconvert(root) == {"a_b": "a b", "_7_": "{7}", "x_y": "x y"}
    assert [(item.get("id"), item.get("junction")) for item in root.iterfind("road")] == [("a_b", "-1"), ("_7_", "x_y")]
    assert [item.get("elementId") for item in root.iterfind("road/link/")] == ["x_y", "a_b"]
    connection = root.find("junction[@id='x_y']/connection")
    assert connection is not None
    assert (connection.get("incomingRoad"), connection.get("connectingRoad")) == ("a_b", "_7_")


@pytest.mark.parametrize(
    ("given", "changed"),
    [
        (["1", "2.5", "-3", "é(4)"], {}),
        (["1", "-1"], {"1_": "-1"}),
        (["1", "1#0"], {"1_0": "1#0"}),
        (["a b", "a_b"], {"a_b_": "a b"}),
        (["", ":1"], {"_": "", "_1": ":1"}),
    ],
)
def test_only_names_that_cannot_stay_are_changed(tmp_path: Path, given: list[str], changed: dict[str, str]) -> None:
    root = parse(write(tmp_path, document(*(road(TWO_WAY, number=name) for name in given))))
    assert rename_for_netconvert(root) == changed


def test_lanes_of_the_net_bear_the_names_of_the_map() -> None:
    net = ElementTree.fromstring('<net><lane><param key="origId" value="a_b_-2"/></lane></net>')
    restore_names(net, {"a_b": "a b"})
    assert [item.get("value") for item in net.iter("param")] == ["a b_-2"]


def test_map_with_such_names_is_imported_whole(tmp_path: Path) -> None:
    names = ["a b", "{3f-0}", "x;y"]
    places = (LINE.replace('y="0"', f'y="{50 * row}"') for row in range(len(names)))
    roads = [road(TWO_WAY, place, number=name) for name, place in zip(names, places, strict=True)]
    source = write(tmp_path, document(*roads))
    done = import_map(
        source, tmp_path / "map.net.xml", origin_deg=None, alarm_m={}, overwrite=False, tell=lambda stage: None
    )
    lanes = net_lanes(ElementTree.parse(done.net).getroot())
    assert {lane.original for lane in lanes} == {f"{name}_{number}" for name in names for number in (-1, 1)}
    assert done.check.overall.unmatched_share == 0.0
    assert {line.road_id for line in done.check.lines} == set(names)
    assert any("'a b' is 'a_b' there" in sentence for sentence in done.mended)
