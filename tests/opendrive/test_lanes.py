"""Lane centres of small maps, by hand."""

from pathlib import Path

import numpy as np
import pytest

from gpsec.opendrive.lanes import CentreLine, centre_lines, paths
from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.spelling import spell_out

from .maps import LINE, document, lane, road, section, write


def lines(folder: Path, *written: str) -> dict[tuple[int, int], CentreLine]:
    path = write(folder, document(*written))
    root = parse(path)
    spell_out(root)
    found = centre_lines(roads(root, path), 1.0)
    return {(line.section, line.lane_id): line for line in found}


def test_lanes_lie_beside_each_other_and_are_driven_on_the_right(tmp_path: Path) -> None:
    found = lines(tmp_path, road(section(lane(1, 3.0), lane(-2, 3.5) + lane(-1, 4.0))))
    assert {key: (line.points_m[0, 1], line.points_m[-1, 0] - line.points_m[0, 0]) for key, line in found.items()} == {
        (0, 1): (1.5, pytest.approx(-100.0)),
        (0, -1): (-2.0, pytest.approx(100.0)),
        (0, -2): (-5.75, pytest.approx(100.0)),
    }
    assert found[0, 1].heading_rad == pytest.approx(np.pi)
    assert np.abs(np.diff(found[0, -1].points_m[:, 0])).max() <= 1.0 + 1e-9


def test_left_hand_traffic_drives_on_the_left(tmp_path: Path) -> None:
    found = lines(tmp_path, road(section(lane(1), lane(-1)), rule="LHT"))
    assert found[0, 1].heading_rad == pytest.approx(0.0)
    assert np.abs(found[0, -1].heading_rad) == pytest.approx(np.pi)


def test_centre_on_an_arc_is_on_a_circle_of_its_own(tmp_path: Path) -> None:
    arc = '<geometry s="0" x="10" y="5" hdg="1" length="50"><arc curvature="0.02"/></geometry>'
    found = lines(tmp_path, road(section(lane(1), lane(-1)), arc, 50.0))
    centre = np.array([10.0, 5.0]) + 50.0 * np.array([-np.sin(1.0), np.cos(1.0)])
    assert np.hypot(*(found[0, -1].points_m - centre).T) == pytest.approx(51.75)
    assert np.hypot(*(found[0, 1].points_m - centre).T) == pytest.approx(48.25)


def test_widths_and_offset_are_polynomials(tmp_path: Path) -> None:
    wide = '<width sOffset="0" a="3" b="0.01" c="0" d="0"/><width sOffset="50" a="3.5" b="0" c="1e-3" d="1e-5"/>'
    offset = '<laneOffset s="0" a="1" b="0" c="0" d="0"/><laneOffset s="60" a="1" b="0.1" c="0" d="0"/>'
    found = lines(tmp_path, road(section("", lane(-1, wide) + lane(-2, 2.0)), offset=offset))
    for s in (20.0, 50.0, 80.0):
        width = 3.0 + 0.01 * s if s < 50.0 else 3.5 + 1e-3 * (s - 50.0) ** 2 + 1e-5 * (s - 50.0) ** 3
        centre = 1.0 if s < 60.0 else 1.0 + 0.1 * (s - 60.0)
        at = int(s)
        assert found[0, -1].width_m[at] == pytest.approx(width)
        assert found[0, -1].points_m[at] == pytest.approx((s, centre - 0.5 * width))
        assert found[0, -2].points_m[at] == pytest.approx((s, centre - width - 1.0))


def test_border_is_measured_from_the_centre_lane(tmp_path: Path) -> None:
    border = '<border sOffset="0" a="-6.5" b="0" c="0" d="0"/>'
    found = lines(tmp_path, road(section("", lane(-1, 3.5) + lane(-2, border))))
    assert found[0, -2].width_m == pytest.approx(3.0)
    assert found[0, -2].points_m[:, 1] == pytest.approx(-5.0)


def test_widths_lie_in_the_tilted_plane(tmp_path: Path) -> None:
    tilt = '<superelevation s="0" a="0.1" b="0" c="0" d="0"/>'
    found = lines(tmp_path, road(section("", lane(-1, 4.0)), lateral=tilt))
    assert found[0, -1].points_m[:, 1] == pytest.approx(-2.0 * np.cos(0.1))


def test_level_lanes_are_horizontal_beside_tilted_ones(tmp_path: Path) -> None:
    tilt = '<superelevation s="0" a="0.3" b="0" c="0" d="0"/>'
    level = lane(-2, 3.0).replace('level="false"', 'level="true"')
    found = lines(tmp_path, road(section("", lane(-1, 4.0) + level), lateral=tilt))
    assert found[0, -1].points_m[:, 1] == pytest.approx(-2.0 * np.cos(0.3))
    assert found[0, -2].points_m[:, 1] == pytest.approx(-4.0 * np.cos(0.3) - 1.5)


def test_reversed_lane_is_driven_against_its_side(tmp_path: Path) -> None:
    against = lane(-2).replace("<lane ", '<lane direction="reversed" ')
    found = lines(tmp_path, road(section("", lane(-1) + against)))
    assert found[0, -1].heading_rad == pytest.approx(0.0)
    assert np.abs(found[0, -2].heading_rad) == pytest.approx(np.pi)


@pytest.mark.parametrize(("number", "radius"), [(1, 18.25), (-1, 21.75), (-8, 46.25)])
def test_points_are_evenly_spaced_along_the_lane_itself(number: int, radius: float, tmp_path: Path) -> None:
    half = 20.0 * np.pi
    arc = f'<geometry s="0" x="0" y="0" hdg="0" length="{half}"><arc curvature="0.05"/></geometry>'
    right = "".join(lane(-at) for at in range(1, 9))
    found = lines(tmp_path, road(section(lane(1), right), arc, half))[0, number]
    gaps = np.hypot(*np.diff(found.points_m, axis=0).T)
    assert gaps == pytest.approx(np.pi * radius / len(gaps), rel=1e-3)
    assert 0.9 < gaps.mean() <= 1.0


def test_lanes_that_nobody_drives_on_take_their_room(tmp_path: Path) -> None:
    found = lines(tmp_path, road(section("", lane(-1, 1.0, "shoulder") + lane(-2, 3.0))))
    assert list(found) == [(0, -2)]
    assert found[0, -2].points_m[:, 1] == pytest.approx(-2.5)


def test_a_way_follows_lanes_that_change_their_number(tmp_path: Path) -> None:
    def link(before: int | None, behind: int | None) -> str:
        pair = (("predecessor", before), ("successor", behind))
        inside = "".join(f'<{which} id="{to}"/>' for which, to in pair if to is not None)
        return f"<link>{inside}</link>"

    first = section(lane(1, inside=link(None, 1)), lane(-1, inside=link(None, -2)))
    second = section(lane(1, inside=link(1, None)), lane(-1) + lane(-2, inside=link(-1, None)), s=40.0)
    path = write(tmp_path, document(road(first + second)))
    found = list(paths(list(centre_lines(roads(parse(path), path), 1.0))))
    ways = [[(line.section, line.lane_id) for line in way] for way in found]
    assert sorted(ways) == [[(0, -1), (1, -2)], [(1, -1)], [(1, 1), (0, 1)]]


def test_reference_line_of_several_curves(tmp_path: Path) -> None:
    quarter = 10.0 * np.pi
    geometry = (
        LINE
        + f'<geometry s="100" x="100" y="0" hdg="0" length="{quarter}"><arc curvature="0.05"/></geometry>'
        + f'<geometry s="{100 + quarter}" x="120" y="20" hdg="{np.pi / 2}" length="10"><line/></geometry>'
    )
    path = write(tmp_path, document(road(section("", lane(-1)), geometry, 110.0 + quarter)))
    points, heading = roads(parse(path), path)[0].reference(np.array([50.0, 100.0 + quarter / 2, 105.0 + quarter]))
    middle = (100.0 + 20.0 * np.sin(np.pi / 4), 20.0 - 20.0 * np.cos(np.pi / 4))
    assert points == pytest.approx(np.array([(50.0, 0.0), middle, (120.0, 25.0)]))
    assert heading == pytest.approx([0.0, np.pi / 4, np.pi / 2])
