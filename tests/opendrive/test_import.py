"""A map goes in, a net comes out whose lanes lie where the map's do."""

import csv
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec import cli
from gpsec.hdmap.net import read_net
from gpsec.opendrive.importing import Imported, import_map
from gpsec.opendrive.report import CHECK_COLUMNS

from .maps import TWO_WAY, document, lane, road, section, write

ROOT = Path(__file__).parents[2]
Import = Callable[..., Imported]


@pytest.fixture
def imported(tmp_path: Path) -> Import:
    def run(*roads: str, **options: str | None) -> Imported:
        source = write(tmp_path, document(*roads, **options))  # type: ignore[arg-type]
        return import_map(
            source,
            tmp_path / "map.net.xml",
            origin_deg=None,
            alarm_m={"sharp": 0.001, "dull": 5.0},
            overwrite=False,
            tell=lambda stage: None,
        )

    return run


def shapes(done: Imported) -> dict[str, np.ndarray]:
    return {lane.lane_id: lane.shape_m for lane in read_net(done.net).lanes if not lane.internal}


def test_shipped_map_end_to_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["import", str(ROOT / "sumo_nets" / "sharp_turns" / "sharp_turns.xodr")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("sharp_turns.net.xml: ")
    assert "unmatched" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "sharp_turns.check.csv",
        "sharp_turns.check.png",
        "sharp_turns.net.xml",
        "sharp_turns.paint.csv",
    ]
    with (tmp_path / "sharp_turns.check.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == CHECK_COLUMNS
    assert max(float(row["p95_m"]) for row in rows if row["p95_m"]) < 0.05
    assert sum(float(row["unmatched_share"]) * int(row["points"]) for row in rows) < 10.0
    assert (tmp_path / "sharp_turns.check.png").read_bytes().startswith(b"\x89PNG")
    written = (tmp_path / "sharp_turns.net.xml").read_text()
    assert str(ROOT) not in written
    assert str(tmp_path) not in written
    links = [link for link in ElementTree.fromstring(written).iterfind("connection") if link.get("via")]
    assert all(link.get("shape") for link in links if not link.get("from", "").startswith(":"))
    # The roads are those that sumo_nets makes of the same map, with a lane for each of theirs.
    ours = {lane.lane_id for lane in read_net(tmp_path / "sharp_turns.net.xml").lanes if not lane.internal}
    theirs = {
        lane.lane_id for lane in read_net(ROOT / "sumo_nets/sharp_turns/sharp_turns.net.xml").lanes if not lane.internal
    }
    assert ours == theirs


def test_lane_that_opens_inside_a_section_is_there_from_its_beginning(imported: Import) -> None:
    """As docs/opendrive.md says: 1.8 m wide until it has that width, then as wide as it gets, and it is named."""
    opening = (
        '<width sOffset="0" a="0" b="0" c="0" d="0"/><width sOffset="40" a="0" b="0.1" c="0" d="0"/>'
        '<width sOffset="75" a="3.5" b="0" c="0" d="0"/>'
    )
    done = imported(road(section("", lane(-1) + lane(-2, opening))))
    lanes = {lane.lane_id: lane for lane in read_net(done.net).lanes if not lane.internal}
    narrow, wide = lanes["-1#0_0"], lanes["-1#1_0"]
    assert (narrow.width_m, wide.width_m) == (1.8, 3.5)
    # The map has nothing there before 40 m, and a lane of 1.8 m at 58 m; the net cuts it about there.
    assert narrow.shape_m[0, 0] < 1.0
    assert wide.shape_m[0, 0] == pytest.approx(58.0, abs=3.0)
    assert [note for note in done.notes if "narrower than 2 m" in note and "-1#0_0" in note]


def test_lane_beside_one_that_opens_keeps_its_place(imported: Import) -> None:
    opening = '<width sOffset="0" a="2" b="0" c="0" d="0"/><width sOffset="20" a="2" b="0.03" c="0" d="0"/>'
    done = imported(road(section("", lane(-1, opening) + lane(-2, 3.0))))
    shape = shapes(done)["-1_0"]
    expected = -np.interp(shape[:, 0], [0.0, 20.0, 100.0], [3.5, 3.5, 5.9])
    assert shape[:, 1] == pytest.approx(expected, abs=2e-3)
    assert done.raw.p95_m is not None
    assert done.raw.p95_m > 0.5  # netconvert stacks lanes of constant width
    assert done.check.overall.largest_m is not None
    assert done.check.overall.largest_m < 0.01
    assert done.check.over_share["dull"] == 0.0


def test_left_hand_traffic(imported: Import) -> None:
    done = imported(road(section(lane(1, 3.0), lane(-1, 4.0)), rule="LHT"))
    assert {name: shape[0] @ [0, 1] for name, shape in shapes(done).items()} == {
        "-1_0": pytest.approx(1.5, abs=1e-3),
        "1_0": pytest.approx(-2.0, abs=1e-3),
    }
    assert shapes(done)["-1_0"][0, 0] < shapes(done)["-1_0"][-1, 0]
    assert any("keeps left" in sentence for sentence in done.mended)
    assert done.check.overall.unmatched_share == 0.0


@pytest.mark.parametrize("rule", ["RHT", "LHT"])
@pytest.mark.parametrize("shuffled", [False, True], ids=["in order", "in any order"])
def test_lanes_are_counted_from_the_edge_of_the_road(rule: str, shuffled: bool, imported: Import) -> None:
    left, right = [lane(3), lane(2), lane(1)], [lane(-1), lane(-2), lane(-3)]
    if shuffled:
        left, right = left[1:] + left[:1], right[::-1]
    done = imported(road(section("".join(left), "".join(right)), rule=rule))
    for edge in ("1", "-1"):
        away = [abs(shapes(done)[f"{edge}_{index}"][0, 1]) for index in range(3)]
        assert away == pytest.approx([8.75, 5.25, 1.75], abs=1e-3)


def test_speeds_that_netconvert_loses(imported: Import) -> None:
    kind = '<type s="0" type="town"><speed max="25" unit="mph"/></type>'
    bad = '<speed sOffset="0" max="-1" unit="km/h"/>'
    done = imported(
        road(section(lane(1, inside=bad), lane(-1)), kind=kind),
        road(
            section("", lane(-1, inside=bad)),
            length=100.0,
            number="2",
            geometry='<geometry s="0" x="0" y="50" hdg="0" length="100"><line/></geometry>',
        ),
    )
    lanes = ElementTree.parse(done.net).getroot().iterfind("edge/lane")
    speeds = {
        item.get("id"): float(item.get("speed", "0")) for item in lanes if not item.get("id", ":").startswith(":")
    }
    assert speeds["-1_0"] == speeds["1_0"] == pytest.approx(11.176)
    assert speeds["-2_0"] > 0.0
    assert any("speed limits of 0 or less, left out: 2" in sentence for sentence in done.mended)
    assert any("parts of the net that no road joins: 2" in sentence for sentence in done.notes)


def test_map_without_a_reference_gets_one(imported: Import) -> None:
    done = imported(road(TWO_WAY), reference=None)
    assert read_net(done.net).projector.to_lon_lat(np.zeros(2)) == pytest.approx([10.5268, 52.2647])


def test_narrow_lanes_are_said_and_left_out(imported: Import) -> None:
    done = imported(road(section("", lane(-1, 3.0) + lane(-2, 1.9))))
    assert any("lanes narrower than 2 m: 1; '-1_0' is 1.90 m wide" in sentence for sentence in done.notes)
    assert done.check.narrow_share == 0.0


def test_what_is_narrower_than_any_vehicle_is_not_compared(imported: Import) -> None:
    closing = '<width sOffset="0" a="3" b="-0.02" c="0" d="0"/>'  # 1.8 m after 60 of 100 m
    done = imported(road(section("", lane(-1, closing))))
    assert done.check.narrow_share == pytest.approx(0.4, abs=0.01)
    assert done.check.overall.unmatched_share == pytest.approx(0.0, abs=0.01)


def test_columns_are_described() -> None:
    described = (ROOT / "docs" / "opendrive.md").read_text()
    assert [column for column in CHECK_COLUMNS if f"`{column}`" not in described] == []


def test_same_map_gives_the_same_bytes(tmp_path: Path) -> None:
    source = write(tmp_path, document(road(TWO_WAY)))
    contents = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        done = import_map(
            source,
            tmp_path / name / "map.net.xml",
            origin_deg=None,
            alarm_m={},
            overwrite=False,
            tell=lambda stage: None,
        )
        contents.append([path.read_bytes() for path in (done.net, done.csv, done.picture)])
    assert contents[0] == contents[1]
