"""Numbers of a map that no map can have: each is one sentence, and takes neither time nor memory."""

from pathlib import Path

import pytest

from gpsec import cli

from .maps import document, lane, road, section, write

BORDER = '<border sOffset="0" a="-7" b="0" c="0" d="0"/>'
MAP = document(
    road(
        section(lane(1), lane(-1) + lane(-2, BORDER)) + section(lane(1), lane(-1), 40.0),
        '<geometry s="0" x="1" y="2" hdg="0.5" length="100"><arc curvature="0.01"/></geometry>',
        offset='<laneOffset s="0" a="0.25" b="0" c="0" d="0"/>',
        lateral='<superelevation s="0" a="0.125" b="0" c="0" d="0"/>',
    )
)
# Where the number is, and what stands there in a good map.
PLACES = {
    "road length": 'length="100.0"',
    "section": '<laneSection s="40.0"',
    "geometry station": '<geometry s="0"',
    "geometry x": 'x="1"',
    "geometry heading": 'hdg="0.5"',
    "curvature": 'curvature="0.01"',
    "lane": '<lane id="-2"',
    "width": 'a="3.5"',
    "width offset": '<width sOffset="0"',
    "border": 'a="-7"',
    "lane offset": 'a="0.25"',
    "superelevation": 'a="0.125"',
}
VALUES = ["nan", "inf", "-1e308", "1e300", "-2147483649", "", "1,5", "0x10", "1_0", "٣"]


def import_of(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    source = write(folder, text)
    status = cli.main(["import", str(source), "--out", str(folder / "made.net.xml"), "--overwrite"])
    return status, capsys.readouterr().err


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize("place", PLACES)
def test_number_that_is_none_or_beyond_bounds_is_refused(
    place: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = PLACES[place].rpartition("=")[0]
    status, said = import_of(MAP.replace(PLACES[place], f'{key}="{value}"'), tmp_path, capsys)
    assert status == 2, said
    assert said.startswith(f"gpsec: error: {tmp_path / 'map.xodr'}: road '1'")
    assert said.count("\n") == 1


def test_good_map_is_none_of_these(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert import_of(MAP, tmp_path, capsys)[0] == 0


@pytest.mark.parametrize("number", ["-1.5", "10001"])
def test_lane_id_is_a_whole_number(number: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, said = import_of(MAP.replace('<lane id="-2"', f'<lane id="{number}"'), tmp_path, capsys)
    assert status == 2
    assert "<lane>: expected a whole number from -10000 to 10000 for 'id'" in said


def test_lane_id_that_is_there_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, said = import_of(MAP.replace('<lane id="-2"', '<lane id="-1"'), tmp_path, capsys)
    assert status == 2
    assert "road '1': laneSection at s=0: expected one lane of each id, found several with -1" in said


@pytest.mark.parametrize("s", ["0", "1e-9", "40", "99.9999999", "500"])
def test_sections_that_begin_together_or_behind_the_end(
    s: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sections = section("", lane(-1)) + section("", lane(-1) + lane(-2), 40.0).replace('s="40.0"', f's="{s}"')
    assert import_of(document(road(sections)), tmp_path, capsys)[0] in (0, 1)


def test_elements_deep_in_each_other_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deep = MAP.replace("<planView>", "<userData>" * 3000 + "</userData>" * 3000 + "<planView>")
    status, said = import_of(deep, tmp_path, capsys)
    assert status == 2
    assert "deep in each other" in said
