"""Every way in which a map can be wrong is one sentence, exit status 2, and nothing on the disk."""

from pathlib import Path

import pytest

from gpsec import cli

from .maps import LINE, TWO_WAY, document, lane, road, section, write

GOOD = document(road(TWO_WAY))


def geometry(inside: str) -> str:
    return document(road(TWO_WAY, LINE.replace("<line/>", inside)))


MAPS = {
    "not XML": ("hello", ("no XML",)),
    "binary": ("\x00\x01\x02", ("no XML",)),
    "cut short": (GOOD[:300], ("no XML",)),
    "unknown encoding": (GOOD.replace('version="1.0"?', 'version="1.0" encoding="foo-8"?', 1), ("no XML",)),
    "a net": ('<net version="1.20"/>', ("found <net>",)),
    "no roads": (document(), ("at least one road",)),
    "no lane to drive": (document(road(section("", lane(-1, kind="sidewalk")))), ("that traffic drives on",)),
    "no lane at all": (document(road("")), ("that traffic drives on",)),
    "unknown geometry": (geometry("<helix/>"), ("road '1'", "s=0", "line, arc, spiral", "<helix>")),
    "geometry without a curve": (geometry(""), ("road '1'", "found none")),
    "arc without curvature": (geometry("<arc/>"), ("road '1'", "<arc>", "'curvature'", "found none")),
    "text for a number": (geometry('<arc curvature="x"/>'), ("<arc>", "'curvature'", "'x'")),
    "not finite": (GOOD.replace('hdg="0"', 'hdg="nan"'), ("<geometry>", "'hdg'", "'nan'")),
    "endless road": (
        GOOD.replace('<road name="" length="100.0"', '<road name="" length="1e9"'),
        ("<road>", "1e+06", "'1e9'"),
    ),
    "more road than memory holds": (
        document(*(road(TWO_WAY, LINE, 9e5, number=f"{number}") for number in range(6))),
        ("at most 5000 km", "found 5400 km"),
    ),
    "unknown unit": (
        document(road(section("", lane(-1, inside='<speed sOffset="0" max="9" unit="knots"/>')))),
        ("road '1'", "speed", "'knots'"),
    ),
    "width that is no number": (GOOD.replace('a="3.5"', 'a="wide"', 1), ("<width>", "'wide'")),
    "lane without a number": (GOOD.replace('<lane id="1"', "<lane", 1), ("<lane>", "'id'")),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(here: Path, arguments: list[str], says: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(here.rglob("*"))
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("gpsec: error: ")
    assert captured.err.count("\n") == 1, captured.err
    assert captured.out == ""
    assert all(fragment in captured.err for fragment in says), captured.err
    assert sorted(here.rglob("*")) == before


@pytest.mark.parametrize("name", MAPS)
def test_map_is_refused(name: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, says = MAPS[name]
    write(here, text)
    refused(here, ["import", "map.xodr"], ("map.xodr", *says), capsys)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere.xodr"], ("nowhere.xodr", "no such file")),
        (["."], ("found no such file",)),
        (["map.xodr", "--out", "town.xml"], ("town.xml", ".net.xml")),
        (["map.xodr", "--out", "no/town.net.xml"], ("no/town.net.xml", "no folder no")),
        (["map.xodr", "--out", "taken.net.xml"], ("taken.net.xml", "--overwrite")),
        (["map.xodr", "--out", "folder.net.xml"], ("folder.net.xml", "it is a folder")),
        (["map.xodr", "--origin", "here"], ("--origin here", "latitude and longitude")),
        (["map.xodr", "--origin", "52.2"], ("--origin 52.2",)),
        (["map.xodr", "--origin", "99,10"], ("--origin 99,10",)),
        (["map.xodr", "--origin", "nan,10"], ("--origin nan,10",)),
    ],
)
def test_argument_is_refused(
    arguments: list[str], says: tuple[str, ...], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(here, GOOD)
    (here / "taken.net.xml").write_text("mine")
    (here / "folder.net.xml").mkdir()
    refused(here, ["import", *arguments], says, capsys)


def test_folder_that_cannot_be_written(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, GOOD)
    refused(here, ["import", "map.xodr", "--out", "/proc/map.net.xml"], ("/proc/map.net.xml", "written"), capsys)


def test_map_that_netconvert_refuses(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, GOOD.replace('junction="-1"', 'junction="5"'))  # all of it is inside a junction
    refused(here, ["import", "map.xodr"], ("map.xodr: netconvert refuses it", "No edges"), capsys)


def test_errors_that_netconvert_can_ignore_are_said(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, GOOD.replace('junction="-1"', ""))
    assert cli.main(["import", "map.xodr"]) == 0
    assert "had to ignore: 1, such as" in capsys.readouterr().out


def test_negative_origin_is_a_place(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, GOOD)
    assert cli.main(["import", "map.xodr", "--origin", "-33.9,151.2"]) == 0
    assert "-33.9, 151.2" in capsys.readouterr().out
