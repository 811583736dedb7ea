"""What is mended in a map before netconvert sees it."""

from pathlib import Path
from xml.etree.ElementTree import Element

import pytest

from gpsec.opendrive import georeference
from gpsec.opendrive.georeference import set_georeference
from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.source import Speeds, spell_out_speeds

from .maps import TMERC, TWO_WAY, document, lane, road, section, write


def speed(limit: str, unit: str = "m/s", at: str = 'sOffset="0"') -> str:
    return f'<speed {at} max="{limit}" unit="{unit}"/>'


def town(limit: str, unit: str, s: float = 0.0) -> str:
    return f'<type s="{s}" type="town"><speed max="{limit}" unit="{unit}"/></type>'


def spelt_out(folder: Path, *written: str) -> tuple[Speeds, list[list[tuple[float, float]]]]:
    path = write(folder, document(*written))
    root = parse(path)
    said = spell_out_speeds(root, roads(root, path))
    lanes = [item for item in root.iter("lane") if item.get("id") != "0"]
    return said, [
        [(float(limit.get("sOffset", "nan")), float(limit.get("max", "nan"))) for limit in item.iterfind("speed")]
        for item in lanes
    ]


def test_limit_of_the_road_is_given_to_its_lanes(tmp_path: Path) -> None:
    said, limits = spelt_out(tmp_path, road(TWO_WAY, kind=town("50", "km/h")))
    assert said == Speeds(2, 0, 0)
    assert limits == [[(0.0, pytest.approx(13.8889))]] * 2


def test_limits_of_the_road_change_where_its_type_does(tmp_path: Path) -> None:
    sections = section("", lane(-1)) + section("", lane(-1), s=40.0)
    kinds = town("25", "mph") + town("10", "m/s", 60.0)
    _, limits = spelt_out(tmp_path, road(sections, kind=kinds))
    assert limits == [[(0.0, pytest.approx(11.176))], [(0.0, pytest.approx(11.176)), (20.0, 10.0)]]


def test_limit_of_the_lane_goes_first(tmp_path: Path) -> None:
    said, limits = spelt_out(tmp_path, road(section("", lane(-1, inside=speed("9"))), kind=town("50", "km/h")))
    assert said == Speeds(0, 0, 0)
    assert limits == [[(0.0, 9.0)]]


def test_limit_that_is_not_positive_is_left_out(tmp_path: Path) -> None:
    said, limits = spelt_out(
        tmp_path, road(section(lane(1, inside=speed("-1", "km/h")), lane(-1, inside=speed("0") + speed("8"))))
    )
    assert said == Speeds(0, 2, 0)
    assert limits == [[], [(0.0, 8.0)]]


def test_no_limit_is_a_motorway(tmp_path: Path) -> None:
    said, limits = spelt_out(tmp_path, road(section("", lane(-1)), kind=town("no limit", "km/h")))
    assert said == Speeds(1, 0, 1)
    assert limits == [[(0.0, pytest.approx(36.1111))]]


def reference(folder: Path, written: str | None, origin: tuple[float, float] | None = None) -> tuple[str, str, Element]:
    root = parse(write(folder, document(road(TWO_WAY), reference=written)))
    said = set_georeference(root, origin)
    return root.findtext("header/geoReference", ""), said, root


def test_usable_reference_stays(tmp_path: Path) -> None:
    assert reference(tmp_path, TMERC)[:2] == (TMERC, "")


@pytest.mark.parametrize(
    ("written", "origin", "place", "says"),
    [
        ("+lat_0=4.9e+1 +lon_0=8", None, "+lat_0=49 +lon_0=8 ", "no projection"),
        (None, None, "+lat_0=52.2647 +lon_0=10.5268 ", "is missing"),
        ("LOCAL", None, "+lat_0=52.2647 +lon_0=10.5268 ", "none that PROJ knows"),
        (TMERC, (-33.9, 151.2), "+lat_0=-33.9 +lon_0=151.2 ", "--origin"),
    ],
)
def test_other_references_become_a_projection(
    tmp_path: Path, written: str | None, origin: tuple[float, float] | None, place: str, says: str
) -> None:
    definition, said, _ = reference(tmp_path, written, origin)
    assert definition.startswith("+proj=tmerc")
    assert place in definition
    assert says in said


def test_heights_are_left_out_where_their_grid_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # As PROJ does, where it knows of a grid that is not installed.
    monkeypatch.setattr(georeference, "_usable", lambda definition: "geoidgrids" not in definition)
    definition, said, _ = reference(tmp_path, "+proj=utm +zone=32 +datum=WGS84 +geoidgrids=egm96_15.gtx +vunits=m")
    assert definition == "+proj=utm +zone=32 +datum=WGS84"
    assert "heights" in said


@pytest.mark.parametrize(("x", "turned"), [(-500000.0, True), (500000.0, False)])
def test_offset_that_leads_out_of_the_zone_is_turned_round(tmp_path: Path, x: float, turned: bool) -> None:
    header = f'<offset x="{x}" y="{x * 10}" z="0" hdg="0"/>'
    root = parse(write(tmp_path, document(road(TWO_WAY), reference="+proj=utm +zone=32 +datum=WGS84", header=header)))
    said = set_georeference(root, None)
    offset = root.find("header/offset")
    assert offset is not None
    assert (float(offset.get("x", "0")), float(offset.get("y", "0"))) == (500000.0, 5000000.0)
    assert bool(said) == turned
