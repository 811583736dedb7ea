"""Where lanes of a net begin and end, how long they are, and what a check says of the rest."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec import cli
from gpsec.opendrive.check import check_lanes
from gpsec.opendrive.extents import extents
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.lengths import agree_lengths, differing
from gpsec.opendrive.mend import describe_net
from gpsec.opendrive.netfile import NetLane, net_lanes
from gpsec.opendrive.polylines import stations
from gpsec.opendrive.ways import Ways

from .maps import document, lane, road, section, write

RADIUS_M = 2.0
TURN_M = np.pi * RADIUS_M


def linked(number: int, before: bool, behind: bool) -> str:
    ends = ("predecessor",) * before + ("successor",) * behind
    inside = "".join(f'<{end} id="{number}"/>' for end in ends)
    return lane(number, inside=f"<link>{inside}</link>")


def u_turn() -> str:
    """Three lanes to the east, around half a circle of 2 m to the left, and back."""
    shapes = [
        (200.0, '<geometry s="0" x="-200" y="0" hdg="0" length="200"><line/></geometry>'),
        (TURN_M, f'<geometry s="0" x="0" y="0" hdg="0" length="{TURN_M}"><arc curvature="0.5"/></geometry>'),
        (200.0, f'<geometry s="0" x="0" y="4" hdg="{np.pi}" length="200"><line/></geometry>'),
    ]
    written = []
    for at, (length, shape) in enumerate(shapes):
        lanes = section("", "".join(linked(-number, at > 0, at < 2) for number in (1, 2, 3)))
        ends = [("predecessor", at, "end")] * (at > 0) + [("successor", at + 2, "start")] * (at < 2)
        links = "".join(
            f'<{kind} elementType="road" elementId="{other}" contactPoint="{point}"/>' for kind, other, point in ends
        )
        one = road(lanes, shape, length, number=str(at + 1))
        written.append(one.replace("<planView>", f"<link>{links}</link><planView>"))
    return document(*written)


def imported(folder: Path, text: str, *options: str) -> tuple[int, ElementTree.Element]:
    source, target = write(folder, text), folder / "map.net.xml"
    status = cli.main(["import", str(source), "--out", str(target), "--overwrite", *options])
    return status, ElementTree.parse(target).getroot()


def test_lanes_of_a_tight_turn_keep_the_maps_shape(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, net = imported(tmp_path, u_turn())
    said = capsys.readouterr().out
    assert status == 0
    lanes = {item.lane_id: item for item in net_lanes(net)}
    drawn = {index: stations(lanes[f"-2_{index}"].points_m)[-1] for index in range(3)}
    for index, radius in ((0, 10.75), (1, 7.25), (2, 3.75)):
        shape = lanes[f"-2_{index}"].points_m
        assert np.hypot(shape[:, 0], shape[:, 1] - RADIUS_M) == pytest.approx(radius, abs=0.03)
        assert drawn[index] > 0.5 * np.pi * radius
        # From one straight road to the other, nothing is missing: lanes and what leads to and from them are the map's.
        through = [lanes[f":{name}_0_{index}"].points_m for name in ("2.1", "3.2")]
        whole = stations(np.concatenate([through[0], shape, through[1]]))[-1]
        assert whole == pytest.approx(np.pi * radius, rel=0.02)
    lengths = [float(lanes[f"-2_{index}"].element.get("length", "nan")) for index in range(3)]
    assert lengths == pytest.approx([np.mean(list(drawn.values()))] * 3, abs=1e-3)
    assert "differ by more than 10%" in said
    assert f"'-2_0' ({drawn[0]:.1f} m of shape for" in said


def test_import_that_lost_lanes_fails_unless_that_is_accepted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    against = lane(-2).replace("<lane ", '<lane direction="reversed" ')
    text = document(road(section(lane(1), lane(-1) + against)))
    status, net = imported(tmp_path, text)
    said = capsys.readouterr()
    assert status == 1
    assert {item.lane_id for item in net_lanes(net)} == {"1_0", "-1_0"}
    assert "33.3% of its lanes' length, more than 3%" in said.err
    assert "which was written; --allow-loss accepts that" in said.err
    assert "the net has not, or less than half of: 1, lane -2 of road '1' (s=0 to 100 m)" in said.out
    assert "against their side" in said.out
    assert imported(tmp_path, text, "--allow-loss")[0] == 0


def line(y: float, number: int) -> CentreLine:
    x = np.arange(0.0, 100.5, 0.5)
    return CentreLine("7", 0, number, "driving", x, np.stack([x, x * 0.0 + y], axis=1), x * 0.0, x * 0.0 + 3.5, 1, None)


def net_lane(index: int, number: int, *points: tuple[float, float]) -> NetLane:
    element = ElementTree.Element("lane", length="50")
    return NetLane(f"e_{index}", f"7_{number}", False, 3.5, 9.0, np.array(points), element)


def placed(*lanes: NetLane) -> list[tuple[float, float] | None]:
    found = extents(list(lanes), Ways([line(0.0, -1), line(3.5, -2), line(7.0, -3)]))
    return [(found[at].begin_m, found[at].finish_m) if at in found else None for at in range(len(lanes))]


def test_lanes_of_an_edge_are_the_same_piece_of_the_road() -> None:
    # One lane is cut short at its beginning, one has shrunk to nothing at its end.
    found = placed(
        net_lane(0, -1, (10.0, 0.0), (90.0, 0.0)),
        net_lane(1, -2, (14.0, 3.5), (94.0, 3.5)),
        net_lane(2, -3, (92.0, 7.0), (92.1, 7.0)),
    )
    assert found == [(pytest.approx(12.0), pytest.approx(92.0))] * 3


def test_edge_of_which_nothing_is_left_is_all_of_its_section() -> None:
    assert placed(net_lane(0, -1, (97.0, 0.0), (97.2, 0.0))) == [(pytest.approx(0.0), pytest.approx(100.0))]
    # Not where another edge has its share of the section.
    two = [net_lane(0, -1, (97.0, 0.0), (97.2, 0.0)), net_lane(0, -1, (0.0, 0.0), (97.0, 0.0))]
    two[1] = NetLane("f_0", *[getattr(two[1], name) for name in list(NetLane.__dataclass_fields__)[1:]])
    assert placed(*two) == [(pytest.approx(97.0), pytest.approx(97.2)), (pytest.approx(0.0), pytest.approx(97.0))]


def test_lanes_of_an_edge_get_the_mean_length_of_their_shapes() -> None:
    lanes = '<lane id="e_0" shape="0,0 30,0" length="7"/><lane id="e_1" shape="0,3 24,3" length="7"/>'
    other = '<lane id="f_0" shape="0,9 0.05,9" length="7"/>'
    net = ElementTree.fromstring(f'<net><edge id="e">{lanes}</edge><edge id="f">{other}</edge></net>')
    assert [name.partition(" ")[0] for name in differing(net_lanes(net))] == ["'e_0'", "'e_1'", "'f_0'"]
    agree_lengths(net, net_lanes(net))
    assert [float(item.get("length", "nan")) for item in net.iter("lane")] == [27.0, 27.0, 0.1]
    assert differing(net_lanes(net)) == ["'e_0' (30.0 m of shape for 27.0 m)", "'e_1' (24.0 m of shape for 27.0 m)"]


def test_check_names_the_lanes_that_are_lost() -> None:
    lines = [line(0.0, -1), line(3.5, -2)]
    half = net_lane(0, -2, (0.0, 3.5), (48.0, 3.5))
    check = check_lanes(lines, [net_lane(1, -1, (0.0, 0.0), (100.0, 0.0)), half], {})
    assert check.lost == ("lane -2 of road '7' (s=0 to 100 m)",)
    assert check.incomplete
    assert not check_lanes(lines[:1], [net_lane(1, -1, (0.0, 0.0), (98.0, 0.0))], {}).incomplete


@pytest.mark.parametrize(("left_hand", "said"), [("false", False), ("true", True)])
def test_lanes_that_are_numbered_inside_out_are_said(left_hand: str, said: bool) -> None:
    lanes = '<lane id="e_0" shape="0,0 9,0"/><lane id="e_1" shape="0,3 9,3"/>'
    net = ElementTree.fromstring(f'<net lefthand="{left_hand}"><edge id="e" from="a">{lanes}</edge></net>')
    assert any("SUMO's order: 1, such as 'e'" in sentence for sentence in describe_net(net)) == said
