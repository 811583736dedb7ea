"""An extract goes in, a net comes out that cars drive on, on the right side of the road and of the Earth."""

import bz2
import csv
import gzip
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec import cli
from gpsec.hdmap.net import read_net
from gpsec.openstreetmap import extract

from .maps import CROSSING, CROSSING_NODES, CROSSING_WAYS, LAT, LON, document, write


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def lanes(net: Path) -> dict[str, np.ndarray]:
    return {lane.lane_id: lane.shape_m for lane in read_net(net).lanes if not lane.internal}


def test_net_has_the_roads_of_cars_at_their_place(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, CROSSING)
    assert cli.main(["import", "town.osm"]) == 0
    assert sorted(path.name for path in here.iterdir()) == ["town.net.xml", "town.osm"]
    said = capsys.readouterr().out
    assert said.startswith("town.net.xml: 14 lanes, 3.7 km of them\n")
    assert "traffic keeps right, as in most countries" in said
    assert str(here) not in (here / "town.net.xml").read_text()
    root = ElementTree.parse(here / "town.net.xml").getroot()
    # Two lanes each way on the main street, one on the others; nothing of the footway.
    ways = {edge.get("id", "").lstrip("-").partition("#")[0] for edge in root.iterfind("edge[@from]")}
    assert ways == {"1", "2", "3"}
    assert {edge.get("name") for edge in root.iterfind("edge[@from]")} == {"Main Street", None}
    (middle,) = (node for node in root.iterfind("junction") if node.get("type") == "traffic_light")
    place = np.array([float(middle.get(key, "nan")) for key in "xy"])
    assert read_net(here / "town.net.xml").projector.to_lon_lat(place) == pytest.approx([LON, LAT], abs=2e-7)
    assert not [link for link in root.iterfind("connection") if link.get("dir") == "t"]  # no car can turn on the spot


@pytest.mark.parametrize(("option", "side"), [("--right-hand", -1.0), ("--left-hand", 1.0)])
def test_side_of_traffic(here: Path, option: str, side: float) -> None:
    write(here, CROSSING)
    assert cli.main(["import", "town.osm", option]) == 0
    net = read_net(here / "town.net.xml")
    start, end = (net.projector.from_lon_lat(np.array([LON + x / 68_070.0, LAT])) for x in (0.0, 300.0))
    ahead = (end - start) / np.hypot(*(end - start))
    for name in ("1#1_0", "1#1_1"):  # eastwards along way 1
        off = lanes(here / "town.net.xml")[name].mean(axis=0) - start
        assert side * (ahead[0] * off[1] - ahead[1] * off[0]) > 1.0


@pytest.mark.parametrize(
    ("name", "packed"),
    [
        ("town.osm.gz", gzip.compress(CROSSING.encode())),
        ("town.osm.bz2", bz2.compress(CROSSING.encode())),
        ("town.osm.xml", CROSSING.encode()),
        ("town.xml", CROSSING.encode()),
    ],
)
def test_forms_of_an_extract_make_the_same_net(here: Path, name: str, packed: bytes) -> None:
    write(here, CROSSING, "plain.osm")
    (here / name).write_bytes(packed)
    assert cli.main(["import", "plain.osm"]) == 0
    assert cli.main(["import", name]) == 0
    assert (here / "town.net.xml").read_bytes() == (here / "plain.net.xml").read_bytes()


def test_road_that_leads_nowhere_is_a_net_too(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    street = ([1, 2, 3], {"highway": "residential"})
    far = ([4, 5], {"highway": "unclassified"})
    nodes = {1: (0.0, 0.0), 2: (200.0, 0.0), 3: (400.0, 30.0), 4: (0.0, 200.0), 5: (200.0, 200.0)}
    write(here, document(nodes, [street, far]))
    assert cli.main(["import", "town.osm"]) == 0
    assert "parts of the net that no road joins: 2" in capsys.readouterr().out
    assert cli.main(["demand", "town.net.xml", "--duration", "60"]) == 0


SCHEMA = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="nowhere.xsd"'


@pytest.mark.parametrize(
    "head", ['<!DOCTYPE osm SYSTEM "nowhere.dtd"><osm', "<!DOCTYPE osm [<!ELEMENT other EMPTY>]><osm", f"<osm {SCHEMA}"]
)
def test_schemas_that_an_extract_names_do_not_count(here: Path, head: str) -> None:
    write(here, CROSSING.replace("<osm", head, 1))
    assert cli.main(["import", "town.osm"]) == 0


def test_name_of_an_opendrive_map_may_say_where_it_came_from(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, "<OpenDRIVE/>", "town.osm.xodr")
    refused(here, ["town.osm.xodr"], "town.osm.xodr: expected at least one road, found none", capsys)


def test_from_an_extract_to_results(here: Path) -> None:
    write(here, CROSSING)
    assert cli.main(["import", "town.osm"]) == 0
    assert cli.main(["demand", "town.net.xml", "--period", "1", "--duration", "60"]) == 0
    assert cli.main(["run", "town/town.sumocfg", "--duration", "40", "--out", "results"]) == 0
    with (here / "results" / "vehicles.csv").open(newline="") as stream:
        assert len({row["vehicle_id"] for row in csv.DictReader(stream)}) > 5
    with (here / "results" / "places.csv").open(newline="") as stream:
        places = [(float(row["lon_deg"]), float(row["lat_deg"])) for row in csv.DictReader(stream)]
    assert places
    assert np.abs(np.array(places) - [LON, LAT]).max() < 0.006  # 300 m, and a little


def test_map_that_cars_cannot_use(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, document(CROSSING_NODES, [(CROSSING_WAYS[3][0], {"highway": "footway"})]))
    assert cli.main(["import", "town.osm"]) == 2
    assert capsys.readouterr().err.startswith("gpsec: error: town.osm: netconvert ")
    assert [path.name for path in here.iterdir()] == ["town.osm"]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("<osm", "expected OpenStreetMap data, found no XML"),
        ("", "expected OpenStreetMap data, found no XML"),
        ("<net/>", "expected OpenStreetMap data, found <net>"),
        ("<osm/>", "expected at least one node with a latitude and a longitude, found none"),
        ('<osm><node id="1" lat="x" lon="9"/></osm>', "expected at least one node with a latitude"),
        ('<osm><node id="1" lat="52" lon="9"/></osm>', "expected at least one road, a way with a tag 'highway'"),
        ("\x1f\x8b broken", "expected compressed data, found it damaged"),
    ],
)
def test_extract_is_refused(content: str, says: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "town.osm").write_bytes(content.encode("latin-1"))
    refused(here, ["town.osm"], f"town.osm: {says}", capsys)


def test_extract_that_is_cut_short_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "town.osm.gz").write_bytes(gzip.compress(CROSSING.encode())[:-20])
    refused(here, ["town.osm.gz"], "town.osm.gz: expected compressed data, found it damaged", capsys)


@pytest.mark.parametrize("data", [b"BZh9 broken", bz2.compress(CROSSING.encode())[:-20]])
def test_damaged_bzip2_is_refused(data: bytes, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "town.osm.bz2").write_bytes(data)
    refused(here, ["town.osm.bz2"], "town.osm.bz2: expected compressed data, found it damaged", capsys)


def test_extract_that_fills_the_disk_is_refused(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extract, "MOST_BYTES", 1 << 20)
    (here / "town.osm.gz").write_bytes(gzip.compress(b"<osm>" + b" " * (8 << 20)))
    refused(here, ["town.osm.gz"], "town.osm.gz: expected at most 0.000976562 GiB of XML; cut a piece out", capsys)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["town.osm.pbf"], "town.osm.pbf: expected OpenStreetMap data as XML, found the PBF format; `osmium cat"),
        (["town.osm", "--origin", "52,10"], "--origin 52,10: expected an OpenDRIVE map"),
        (["town.osm", "--out", "town.xml"], "town.xml: expected a name that ends in .net.xml"),
        (["town.osm", "--out", "taken.net.xml"], "taken.net.xml: exists; give --overwrite"),
        (["map.xodr", "--left-hand"], "--left-hand: expected an OpenStreetMap extract"),
    ],
)
def test_argument_is_refused(arguments: list[str], says: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(here, CROSSING)
    for name in ("town.osm.pbf", "taken.net.xml", "map.xodr"):
        (here / name).write_text("mine")
    refused(here, arguments, says, capsys)


def refused(here: Path, arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(here.rglob("*"))
    assert cli.main(["import", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"gpsec: error: {says}"), captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert sorted(here.rglob("*")) == before
