import gzip
import re

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.hdmap.map import compile_map
from gpsec.hdmap.net import read_net

from .nets import BEND, TWO_WAY, net_text


@pytest.fixture(scope="module")
def two_way(plain_net):
    return plain_net(*TWO_WAY)


def lanes(path) -> dict:
    return {lane.lane_id: lane for lane in read_net(path).lanes}


def refused(path, text: str | bytes) -> str:
    """The sentence with which a net of that content is refused."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(GpsecError) as raised:
        read_net(path)
    sentence = str(raised.value)
    assert sentence.startswith(f"{path}: ")
    assert "\n" not in sentence.strip()
    return sentence


def test_lanes_of_a_two_way_road(two_way):
    found = lanes(two_way)
    assert list(found) == ["ab_0", "ab_1", "ba_0"]
    assert found["ab_0"].shape_m == pytest.approx(np.array([[0.0, -4.8], [200.0, -4.8]]))
    assert found["ba_0"].shape_m == pytest.approx(np.array([[200.0, 1.6], [0.0, 1.6]]))
    assert found["ab_0"].edge == found["ab_1"].edge != found["ba_0"].edge
    assert not any(lane.internal or lane.successors for lane in found.values())
    assert {lane.width_m for lane in found.values()} == {3.2}


def test_successors_lead_through_internal_lanes(plain_net):
    found = lanes(plain_net(*BEND))
    inside = found["ab_0"].successors
    assert len(inside) == 2
    assert all(found[name].internal for name in inside)
    assert {name for lane in inside for name in found[lane].successors} == {"bc_0", "bd_0"}
    assert not found["bc_0"].internal
    for lane in found.values():
        for name in lane.successors:
            assert found[name].shape_m[0] == pytest.approx(lane.shape_m[-1], abs=1e-6)


@pytest.mark.parametrize(("length", "named"), [("200.00", ()), ("190.00", ()), ("150.00", ("ba_0",))])
def test_lanes_whose_length_is_not_that_of_their_shape_are_named(two_way, tmp_path, length, named):
    net = tmp_path / "net.net.xml"
    net.write_text(re.sub(r'(<lane id="ba_0"[^>]* length=")[\d.]+"', rf'\g<1>{length}"', net_text(two_way)))
    assert compile_map(net, ()).stretched == named


def test_a_lane_that_is_only_a_point_is_passed_through(plain_net):
    nodes = 'id="a" x="0" y="0"\nid="b" x="90" y="0"\nid="c" x="180" y="0"'
    net = plain_net(nodes, 'id="ab" from="a" to="b" speed="9"\nid="bc" from="b" to="c" speed="9"')
    assert re.search(r'shape="90.0+,-1.60+ 90.0+,-1.60+"', net_text(net)), "netconvert made no such lane"
    found = lanes(net)
    assert list(found) == ["ab_0", "bc_0"]
    assert found["ab_0"].successors == ("bc_0",)
    # A vehicle whose front is on the point is on the lane behind it.
    hd_map = compile_map(net, ())
    assert hd_map.lane_index == {"ab_0": 0, "bc_0": 1, ":b_0_0": 1}


def test_only_lanes_for_road_vehicles(plain_net):
    nodes = "\n".join(f'id="{name}" x="{x}" y="0"' for name, x in (("a", 0), ("b", 90)))
    edges = (
        'id="foot" from="a" to="b" allow="pedestrian" speed="9" shape="0,0 90,0"\n'
        'id="bike" from="a" to="b" allow="bicycle pedestrian" speed="9" shape="0,20 90,20"\n'
        'id="rail" from="a" to="b" allow="rail tram" speed="9" shape="0,40 90,40"\n'
        'id="bus" from="a" to="b" allow="bus bicycle" speed="9" shape="0,60 90,60"\n'
        'id="street" from="a" to="b" sidewalkWidth="2" speed="9" shape="0,80 90,80"'
    )
    assert set(lanes(plain_net(nodes, edges))) == {"bus_0", "street_1"}


def test_net_of_footpaths_only(plain_net):
    net = plain_net(TWO_WAY[0], 'id="foot" from="a" to="b" allow="pedestrian" speed="9"')
    with pytest.raises(GpsecError, match=r"made\.net\.xml: no lane that a road vehicle may use$"):
        read_net(net)


@pytest.mark.parametrize("speed", ["-0.28", "0.00", "nan"])
def test_speed_that_is_not_positive(two_way, tmp_path, speed):
    text = re.sub(r'(<lane id="ab_1"[^>]*speed=)"[^"]*"', rf'\1"{speed}"', net_text(two_way))
    sentence = refused(tmp_path / "slow.net.xml", text)
    assert "lane 'ab_1' has a speed of" in sentence
    assert "expected more than 0" in sentence


def test_missing_net(tmp_path):
    for path in (tmp_path / "none.net.xml", tmp_path):
        with pytest.raises(GpsecError, match="no such net file") as raised:
            read_net(path)
        assert str(raised.value).startswith(str(path))


BROKEN = {
    "empty": lambda text: "",
    "not XML": lambda text: "lanes, widths\n1,2\n",
    "bytes": lambda text: bytes(range(256)),
    "truncated": lambda text: text[: len(text) // 2],
    "lane of unknown speed": lambda text: text.replace('speed="13.900000"', 'speed="fast"'),
    "shape of one number": lambda text: re.sub(r'shape="[^"]*"', 'shape="1"', text),
    "shape that is not finite": lambda text: re.sub(r'(<lane id="ab_0".*?shape=")', r"\1nan,nan ", text),
    "no offset": lambda text: re.sub(r'netOffset="[^"]*"', "", text),
    "broken offset": lambda text: re.sub(r'netOffset="[^"]*"', 'netOffset="here"', text),
    "half an offset": lambda text: re.sub(r'netOffset="[^"]*"', 'netOffset="1"', text),
}


@pytest.mark.parametrize("damage", BROKEN)
def test_broken_net_is_one_sentence(two_way, tmp_path, damage):
    assert "not a SUMO net that can be read" in refused(tmp_path / "broken.net.xml", BROKEN[damage](net_text(two_way)))


@pytest.mark.parametrize("content", ["<net/>", '<routes><vType id="car"/></routes>'])
def test_xml_without_a_lane(tmp_path, content):
    assert "broken.net.xml" in refused(tmp_path / "broken.net.xml", content)


def test_compressed_net(two_way, tmp_path):
    path = tmp_path / "made.net.xml.gz"
    path.write_bytes(gzip.compress(two_way.read_bytes()))
    plain, packed = compile_map(two_way, (5.0,)), compile_map(path, (5.0,))
    assert packed.lane_ids == plain.lane_ids
    assert packed.lanes.x0_m.tobytes() == plain.lanes.x0_m.tobytes()
    for content in (path.read_bytes()[:-40], b"no gzip"):
        assert "not a SUMO net that can be read" in refused(tmp_path / "broken.net.xml.gz", content)


def test_projection_of_the_net(plain_net):
    nodes = 'id="a" x="10.0" y="51.0"\nid="b" x="10.01" y="51.0"'
    net = plain_net(nodes, 'id="ab" from="a" to="b" speed="9"', "--proj.utm")
    projector = read_net(net).projector
    assert projector.has_projection
    start = read_net(net).lanes[0].shape_m[0]
    assert projector.to_lon_lat(start) == pytest.approx([10.0, 51.0], abs=3e-5)  # half a lane beside
