"""`gpsec new`: what it makes runs at once, and it makes nothing of what is wrong."""

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from gpsec import cli
from gpsec.hdmap.net import Lane
from gpsec.scenario import load_scenario
from gpsec.scenario.schema import json_schema
from gpsec.scenario.template import busiest_lane, example_zone
from gpsec.traffic import remote
from gpsec.traffic.session import SumoSession

NODES = 'id="n0" x="0" y="0"\nid="n1" x="200" y="0"\nid="n2" x="500" y="50"\nid="n3" x="200" y="40"'
EDGES = (
    'id="a" from="n0" to="n1" numLanes="2"\nid="b" from="n1" to="n2" numLanes="2"\nid="side" from="n3" to="n1"\n'
    'id="back" from="n2" to="n1"'
)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plain_net: Callable[..., Path]) -> Path:
    """An empty folder, beside one with a net."""
    (tmp_path / "nets").mkdir()
    (tmp_path / "nets" / "cross.net.xml").write_bytes(plain_net(NODES, EDGES).read_bytes())
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setattr(remote, "RemoteSession", SumoSession)  # in this process, which is faster
    return tmp_path / "here"


def test_what_it_makes_is_in_order_at_once(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "my-town", "--net", "../nets/cross.net.xml", "--duration", "60"]) == 0
    assert "gpsec run my-town" in capsys.readouterr().out
    folder = here / "my-town"
    own = {f"my-town.{ending}" for ending in ("netecfg", "sumocfg", "rou.xml", "add.xml")}
    assert {path.name for path in folder.iterdir()} == {
        *own,
        "vehicle_types.add.xml",
        "gpsec.toml",
        "gpsec.schema.json",
    }
    assert [path.name for path in here.iterdir()] == ["my-town"]
    scenario = load_scenario(folder)
    assert (scenario.name, scenario.duration_s) == ("my-town", 60.0)
    assert json.loads((folder / "gpsec.schema.json").read_text("utf-8")) == json_schema()
    assert (folder / "gpsec.toml").read_text("utf-8").startswith("#:schema ./gpsec.schema.json\n")
    assert cli.main(["check", "my-town"]) == 0
    # None, those of the file and the zone.
    assert f"{2 + len(scenario.plans)} plans with none" in capsys.readouterr().out


def test_netedit_and_sumo_are_given_the_same_files_and_they_are_there(here: Path) -> None:
    assert cli.main(["new", "t", "--net", "../nets/cross.net.xml", "--duration", "60"]) == 0
    netedit = ElementTree.parse(here / "t" / "t.netecfg").getroot()
    sumo = ElementTree.parse(here / "t" / "t.sumocfg").getroot()
    for one, other in (("sumo-net-file", "net-file"), ("additional-files",) * 2, ("route-files",) * 2):
        first, second = netedit.find(f".//{one}"), sumo.find(f".//{other}")
        assert first is not None
        assert second is not None
        assert first.get("value") == second.get("value")
        for name in str(first.get("value")).split(","):
            assert (here / "t" / name).is_file(), name


def test_the_same_seed_makes_the_same_folder(here: Path) -> None:
    made = []
    for seed in ("1", "1", "2"):
        assert cli.main(["new", "t", "--net", "../nets/cross.net.xml", "--duration", "60", "--seed", seed]) == 0
        routes = ElementTree.parse(here / "t" / "t.rou.xml").getroot()
        made.append([(each.get("depart"), each.get("type")) for each in routes])
        (here / "t").rename(here / f"was{len(made)}")
    assert made[0] == made[1]
    assert made[0] != made[2]


def lane(name: str, *corners: tuple[float, float]) -> Lane:
    return Lane(name, 0, False, 3.2, 100.0, np.array(corners), ())


LONG = lane("long_0", (0.0, 0.0), (900.0, 0.0))
SHORT = lane("short_0", (0.0, 0.0), (5.0, 0.0))
USED = lane("used_0", (0.0, 0.0), (100.0, 0.0), (100.0, 100.0))
EDGE_OF = {"long_0": "long", "short_0": "short", "used_0": "used"}


@pytest.mark.parametrize(
    ("lanes", "used", "chosen"),
    [
        ([LONG, SHORT, USED], {"used": 5, "short": 9, "long": 1}, USED),
        ([LONG, SHORT, USED], {}, LONG),
        ([SHORT], {"short": 1}, SHORT),
    ],
)
def test_the_zone_lies_where_most_drive_on_a_road_that_is_long_enough(
    lanes: list[Lane], used: dict[str, int], chosen: Lane
) -> None:
    assert busiest_lane(lanes, EDGE_OF, Counter(used)) is chosen


def zone(of: Lane) -> shapely.Polygon:
    shape = ElementTree.fromstring(example_zone(of).partition("\n")[2]).find("poly").get("shape", "")  # type: ignore
    return shapely.Polygon([[float(x) for x in corner.split(",")] for corner in shape.split()])


def test_the_zone_covers_the_middle_half_of_the_lane_but_no_more_than_200_m() -> None:
    """Of 900 m those from 350 to 550, and 20 m on either side."""
    assert zone(LONG).bounds == pytest.approx((350.0, -20.0, 550.0, 20.0))
    assert zone(LONG).area == pytest.approx(200.0 * 40.0)


@pytest.mark.parametrize(
    "winding",
    [
        USED,
        lane("hairpin", (0.0, 0.0), (100.0, 0.0), (100.0, 8.0), (0.0, 8.0)),
        lane("loop", (0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0), (0.0, 1.0)),
    ],
)
def test_the_zone_is_one_valid_polygon_on_the_lane(winding: Lane) -> None:
    area, line = zone(winding), shapely.LineString(winding.shape_m)
    assert area.is_valid
    assert area.contains(line.interpolate(0.5, normalized=True))


REFUSED = {
    "a folder that exists": (["t"], "t: expected a new folder, found one that exists"),
    "a file that exists": (["file"], "file: expected a new folder"),
    "a name that is none": (["a b"], "NAME: expected letters, digits, '.', '_' and '-' only, at most 100, found 'a b'"),
    "the folder itself": (["."], "NAME: expected letters"),
    "a long name": (["x" * 101], "NAME: expected letters"),
    "no folder above": (["no/t2"], "no/t2: cannot be made, there is no folder no"),
    "no net": (["u", "--net", "no.net.xml"], "--net no.net.xml: expected a net of SUMO, found no such file"),
    "a net that is none": (["u", "--net", "file"], "file: not a SUMO net"),
    "an extract": (["u", "--net", "u.osm"], "u.osm: expected a net of SUMO, found an OpenStreetMap extract; make one"),
    "no duration": (["u", "--duration", "0"], "'--duration'"),
    "no period": (["u", "--period", "0"], "'--period'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, says = REFUSED[name]
    (here / "t").mkdir()
    (here / "file").write_text("text")
    (here / "u.osm").write_text("<osm/>")
    before = sorted(here.rglob("*"))
    net = [] if "--net" in arguments else ["--net", "../nets/cross.net.xml"]
    assert cli.main(["new", *arguments, *net]) == 2
    said = capsys.readouterr().err
    assert said.startswith("gpsec: error: ")
    assert said.count("\n") == 1
    assert says in said
    assert sorted(here.rglob("*")) == before
