"""Lane sections and widths in the form that netconvert reads, by hand."""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from gpsec.core.arrays import Floats
from gpsec.opendrive.importing import import_map
from gpsec.opendrive.lanes import CentreLine, centre_lines, paths
from gpsec.opendrive.netfile import net_lanes
from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.road import Cubics
from gpsec.opendrive.sections import lane_number, order_lanes
from gpsec.opendrive.spelling import spell_out

from .maps import document, lane, road, section, write

ON_ONE_SIDE = '<laneSection singleSide="true"'


def spelt(folder: Path, *written: str) -> tuple[Element, list[str], list[CentreLine]]:
    path = write(folder, document(*written))
    root = parse(path)
    said = spell_out(root)
    return root, said, list(centre_lines(roads(root, path), 1.0))


def one_side(left: str = "", right: str = "", s: float = 0.0) -> str:
    return section(left, right, s).replace("<laneSection", ON_ONE_SIDE)


def test_lanes_are_written_from_left_to_right_on_the_side_of_their_number(tmp_path: Path) -> None:
    root = parse(write(tmp_path, document(road(section(lane(1) + lane(-2) + lane(2), lane(-1))))))
    order_lanes(root)
    sides = {side.tag: [lane_number(item) for item in side] for side in root.iterfind("road/lanes/laneSection/*")}
    assert sides == {"left": [2, 1], "center": [0], "right": [-1, -2]}


def test_section_of_one_side_does_not_end_the_lanes_of_the_other(tmp_path: Path) -> None:
    wide = '<width sOffset="0" a="3" b="0.01" c="0" d="1e-5"/><width sOffset="60" a="4" b="0" c="0" d="0"/>'
    sections = section(lane(1, wide), lane(-1)) + one_side("", lane(-1) + lane(-2), 40.0)
    _, said, lines = spelt(tmp_path, road(sections))
    assert any("singleSide" in sentence and sentence.endswith(": 1") for sentence in said)
    found = {(line.section, line.lane_id): line for line in lines}
    assert set(found) == {(0, 1), (0, -1), (1, 1), (1, -1), (1, -2)}
    for number in (0, 1):
        line = found[number, 1]
        s = line.station_m
        expected = np.where(s < 60.0 - 1e-6, 3.0 + 0.01 * s + 1e-5 * s**3, 4.0)
        assert line.width_m == pytest.approx(expected, abs=1e-6)
    ways = [[(line.section, line.lane_id) for line in way] for way in paths(lines)]
    assert [(1, 1), (0, 1)] in ways


def test_sections_of_one_side_that_begin_together_are_one(tmp_path: Path) -> None:
    sections = one_side(lane(1), "") + one_side("", lane(-1)) + one_side("", lane(-1) + lane(-2), 30.0)
    _, _, lines = spelt(tmp_path, road(sections))
    assert sorted((line.section, line.lane_id) for line in lines) == [(0, -1), (0, 1), (1, -2), (1, -1), (1, 1)]


def test_width_between_borders_is_written_as_a_width(tmp_path: Path) -> None:
    inner = '<width sOffset="0" a="3" b="0" c="0" d="0"/><width sOffset="50" a="3" b="0.01" c="0" d="0"/>'
    outer = '<border sOffset="0" a="-6" b="0" c="-1e-4" d="0"/>'
    root, said, lines = spelt(tmp_path, road(section("", lane(-1, inner) + lane(-2, outer))))
    assert any("borders" in sentence and sentence.endswith(": 1") for sentence in said)
    assert root.find(".//border") is None
    (line,) = (line for line in lines if line.lane_id == -2)
    s = line.station_m
    assert line.width_m == pytest.approx(3.0 + 1e-4 * s**2 - 0.01 * np.maximum(s - 50.0, 0.0), abs=1e-6)


def test_lane_without_a_width_is_left_out_and_named(tmp_path: Path) -> None:
    root, said, lines = spelt(tmp_path, road(section(lane(1), lane(-1, "") + lane(-2, 3.0))))
    assert "lanes with neither width nor border, left out: 1, lane -1 of road '1'" in said
    assert {line.lane_id: line.points_m[0, 1] for line in lines} == {1: 1.75, -2: -1.5}
    assert [item.get("type") for item in root.iter("lane") if item.get("id") == "-1"] == ["none"]


def test_width_that_begins_late_is_named(tmp_path: Path) -> None:
    late = '<width sOffset="40" a="3" b="0" c="0" d="0"/>'
    _, said, lines = spelt(tmp_path, road(section("", lane(-1, late))))
    assert any("begins behind" in sentence and "lane -1 of road '1'" in sentence for sentence in said)
    (line,) = lines
    assert line.width_m == pytest.approx(np.where(line.station_m < 40.0, 0.0, 3.0))


def test_lane_of_zero_width_that_is_there_at_once_is_named(tmp_path: Path) -> None:
    late = '<width sOffset="0" a="0" b="0" c="0" d="0"/><width sOffset="40" a="3" b="0" c="0" d="0"/>'
    opens = '<width sOffset="0" a="0" b="0" c="0" d="0"/><width sOffset="40" a="0" b="0.05" c="0" d="0"/>'
    _, said, _ = spelt(tmp_path, road(section(lane(1, opens), lane(-1, late))))
    (sentence,) = (sentence for sentence in said if "begins behind" in sentence)
    assert sentence.endswith(": 1, lane -1 of road '1'")


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ('<width sOffset="0" a="-3.5" b="0" c="0" d="0"/>', lambda s: 0.0 * s),
        ('<width sOffset="0" a="3" b="-0.05" c="0" d="0"/>', lambda s: np.maximum(3.0 - 0.05 * s, 0.0)),
        (  # opens and closes; below zero at both ends
            '<width sOffset="0" a="-4" b="0.28" c="-0.0028" d="0"/>',
            lambda s: np.maximum(-4.0 + 0.28 * s - 0.0028 * s**2, 0.0),
        ),
        (
            '<width sOffset="0" a="3" b="0" c="0" d="0"/><width sOffset="40" a="-3" b="0" c="0" d="0"/>'
            '<width sOffset="70" a="2" b="0" c="0" d="0"/>',
            lambda s: np.select([s < 40.0 - 1e-6, s < 70.0 - 1e-6], [3.0, 0.0], 2.0),
        ),
        ('<border sOffset="0" a="-2" b="0" c="0" d="0"/>', lambda s: 0.0 * s),  # inside that of lane -1
    ],
)
def test_width_below_zero_is_none_and_named(written: str, expected: Callable[[Floats], Floats], tmp_path: Path) -> None:
    root, said, lines = spelt(tmp_path, road(section(lane(1), lane(-1) + lane(-2, written) + lane(-3))))
    assert any("below zero" in sentence and sentence.endswith(": 1, lane -2 of road '1'") for sentence in said)
    found = {line.lane_id: line for line in lines}
    s = found[-2].station_m
    assert found[-2].width_m == pytest.approx(expected(s), abs=1e-6)
    assert -found[-3].points_m[:, 1] == pytest.approx(3.5 + expected(found[-3].station_m) + 1.75, abs=1e-6)
    (spelt_lane,) = (item for item in root.iter("lane") if item.get("id") == "-2")
    cubics = Cubics.of([tuple(float(item.get(key, "")) for key in ("sOffset", *"abcd")) for item in spelt_lane])
    assert cubics.at(s).min() > -1e-9


@pytest.mark.parametrize(
    "written",
    [
        '<width sOffset="0" a="3" b="0" c="-9.015e-4" d="6.01e-6"/>',  # -5 mm at the end: the rest of a fit
        '<width sOffset="0" a="3" b="0" c="0" d="0"/><width sOffset="100" a="-3" b="0" c="0" d="0"/>',  # behind the end
        '<width sOffset="0" a="3" b="1e-30" c="-1e-30" d="-1e-30"/>',
    ],
)
def test_other_widths_stay_as_they_are(written: str, tmp_path: Path) -> None:
    root, said, _ = spelt(tmp_path, road(section("", lane(-1, written))))
    assert not said
    (item,) = (item for item in root.iter("lane") if item.get("id") == "-1")
    assert len(item) == written.count("<width")


def test_lane_of_a_width_below_zero_is_none_of_the_net(tmp_path: Path) -> None:
    path = write(tmp_path, document(road(section(lane(1), lane(-1) + lane(-2, -3.5) + lane(-3)))))
    import_map(path, tmp_path / "map.net.xml", origin_deg=None, alarm_m={}, overwrite=False, tell=lambda _: None)
    originals = {lane.original for lane in net_lanes(ElementTree.parse(tmp_path / "map.net.xml").getroot())}
    assert originals == {"1_1", "1_-1", "1_-3"}


def test_many_names_are_cut_short(tmp_path: Path) -> None:
    roads_ = [road(section("", lane(-1) + lane(-2, "")), number=str(number)) for number in range(1, 6)]
    _, said, _ = spelt(tmp_path, *roads_)
    (sentence,) = (sentence for sentence in said if "neither" in sentence)
    assert sentence.endswith(": 5, such as lane -2 of road '1', lane -2 of road '2', lane -2 of road '3'")
