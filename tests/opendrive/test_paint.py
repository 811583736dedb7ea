"""Road marks of a map become lines of the net's lanes."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec.hdmap.net import read_net
from gpsec.opendrive.importing import import_map
from gpsec.opendrive.paint import borders
from gpsec.opendrive.read import roads
from gpsec.types.paint import PaintedLane, paint_file, read_paint

MAP = Path(__file__).parents[2] / "sumo_nets" / "slow_curve" / "slow_curve.xodr"


def lines(folder: Path, text: str) -> list[PaintedLane]:
    (folder / "map.xodr").write_text(text)
    out = folder / "map.net.xml"
    import_map(folder / "map.xodr", out, origin_deg=None, alarm_m={}, overwrite=True, tell=lambda stage: None)
    return read_paint(paint_file(out))


@pytest.fixture(scope="module")
def shipped(tmp_path_factory) -> tuple[list[PaintedLane], dict[str, float]]:
    folder = tmp_path_factory.mktemp("paint")
    found = lines(folder, MAP.read_text())
    length = {
        lane.lane_id: float(np.hypot(*np.diff(lane.shape_m, axis=0).T).sum())
        for lane in read_net(folder / "map.net.xml").lanes
        if not lane.internal
    }
    return found, length


def test_every_lane_of_a_map_with_marks_has_both_lines_all_along(shipped):
    """A broken line in the middle, a solid one on either side."""
    found, length = shipped
    assert {one.lane for one in found} == set(length)
    assert all(one.left and one.right for one in found)
    for lane, metres in length.items():
        assert sum(one.end_m - one.begin_m for one in found if one.lane == lane) == pytest.approx(metres, abs=0.1)


def without_marks(*lanes: str) -> str:
    """The map whose lanes of these numbers have no marks; of all lanes where none is named."""
    root = ElementTree.fromstring(MAP.read_text())
    for lane in root.iter("lane"):
        if not lanes or lane.get("id") in lanes:
            for mark in lane.findall("roadMark"):
                lane.remove(mark)
    return ElementTree.tostring(root, encoding="unicode")


def test_a_mark_that_is_taken_away_is_missing_on_its_side(tmp_path, shipped):
    """Traffic keeps right: of the outermost lane the outer border is to its right; all else stays."""
    found = lines(tmp_path, without_marks("-2"))
    bare = {one.lane for one in found if not one.right}
    assert bare
    assert bare < set(shipped[1])
    assert all(one.left for one in found)


def test_without_a_reference_line_nothing_is_to_the_left(tmp_path, shipped):
    found = lines(tmp_path, without_marks("0"))
    innermost = {one.lane for one in found if not one.left}
    assert innermost
    assert all(one.right for one in found)
    assert innermost <= set(shipped[1])


def test_without_marks_there_are_no_lines(tmp_path):
    found = lines(tmp_path, without_marks())
    assert found
    assert not any(one.left or one.right for one in found)


def test_a_mark_holds_from_its_offset_on():
    root = ElementTree.fromstring(MAP.read_text())
    lane = next(lane for lane in root.iter("lane") if lane.get("id") == "1")
    for mark in lane.findall("roadMark"):
        lane.remove(mark)
    for offset, kind in (("30", "solid"), ("10", "none"), ("0", "broken"), ("40", "curb")):
        ElementTree.SubElement(lane, "roadMark", sOffset=offset, type=kind)
    there = borders(root)[id(lane)].at(np.array([0.0, 5.0, 15.0, 30.0, 35.0, 45.0]))
    assert there.tolist() == [True, True, False, True, True, False]
    assert roads(root, MAP)


def test_a_map_without_the_reference_lane_has_no_line_there(tmp_path, shipped):
    """OpenDRIVE wants lane 0, and netconvert does without it: the innermost lanes then have no line on their left."""
    root = ElementTree.fromstring(MAP.read_text())
    for section in root.iter("laneSection"):
        section.remove(section.find("center"))
    found = lines(tmp_path, ElementTree.tostring(root, encoding="unicode"))
    assert {one.lane for one in found} == set(shipped[1])
    assert {one.left for one in found} == {True, False}
    assert all(one.right for one in found)
