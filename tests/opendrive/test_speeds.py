"""What is mended in a map before netconvert sees it."""

from pathlib import Path

import pytest

from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.speeds import Speeds, spell_out_speeds

from .maps import TWO_WAY, document, lane, road, section, write


def speed(limit: str, unit: str = "m/s", at: str = 'sOffset="0"') -> str:
    return f'<speed {at} max="{limit}" unit="{unit}"/>'


def town(limit: str, unit: str, s: float = 0.0) -> str:
    return f'<type s="{s}" type="town"><speed max="{limit}" unit="{unit}"/></type>'


def spelt_out(folder: Path, *written: str) -> tuple[Speeds, list[list[tuple[float, float]]]]:
    path = write(folder, document(*written))
    root = parse(path)
    said = spell_out_speeds(roads(root, path))
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
