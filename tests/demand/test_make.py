"""A demand is made for any net, and runs."""

import bz2
import gzip
import signal
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gpsec import cli
from gpsec.demand import trips
from gpsec.demand.make import make_demand, suitable_period_s
from gpsec.demand.trips import straight_flows
from gpsec.hdmap.net import Lane
from gpsec.sumo.tools import run_program


@pytest.fixture(scope="module")
def nets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A grid, and a single road of two lanes in one direction."""
    folder = tmp_path_factory.mktemp("nets")
    grid = ["--grid", "--grid.number=3", "--grid.length=150", "--default.lanenumber=2", "-o", "grid.net.xml"]
    assert run_program("netgenerate", grid, folder).returncode == 0
    (folder / "n.nod.xml").write_text('<nodes><node id="a" x="0" y="0"/><node id="b" x="900" y="0"/></nodes>')
    (folder / "e.edg.xml").write_text('<edges><edge id="r#1" from="a" to="b" numLanes="2" speed="20"/></edges>')
    single = ["-n", "n.nod.xml", "-e", "e.edg.xml", "-o", "single.net.xml", "--no-turnarounds"]
    assert run_program("netconvert", single, folder).returncode == 0
    return {name: folder / f"{name}.net.xml" for name in ("grid", "single")}


def lane(edge: str, number: int, length: float) -> Lane:
    return Lane(f"{edge}_{number}", 0, False, 3.5, length, np.array([[0.0, 0.0], [length, 0.0]]), ())


def made(net: Path, out: Path, seed: int = 1) -> dict[str, bytes]:
    make_demand(net, out, period_s=2.0, duration_s=60.0, seed=seed, overwrite=False, tell=lambda stage: None)
    return {path.name: path.read_bytes() for path in out.iterdir()}


def test_flows_share_the_traffic_by_lanes() -> None:
    lanes = [lane("a", 0, 400.0), lane("a", 1, 400.0), lane("b", 0, 400.0), lane("short", 0, 49.0)]
    text, count = straight_flows(lanes, 2.0, 100.0)
    flows = ElementTree.fromstring(text.encode()).findall("flow")
    assert count == len(flows) == 2
    # Half a departure a second, two thirds of them on the two lanes of a.
    assert [(flow.get("from"), flow.get("to"), flow.get("period")) for flow in flows] == [
        ("a", "a", "exp(0.33333)"),
        ("b", "b", "exp(0.16667)"),
    ]


def test_period_suits_the_size_of_the_net() -> None:
    assert suitable_period_s([lane("a", 0, 15_000.0)]) == pytest.approx(2.0)  # 120 departures an hour and kilometre
    assert suitable_period_s([lane("a", 0, 10.0)]) == 4.0
    assert suitable_period_s([lane(f"{n}", 0, 9e5) for n in range(9)]) == 0.4


def test_random_trips_on_a_grid(nets: dict[str, Path], tmp_path: Path) -> None:
    files = made(nets["grid"], tmp_path / "a")
    assert sorted(files) == ["grid.rou.xml", "grid.sumocfg", "vehicle_types.add.xml"]
    vehicles = ElementTree.fromstring(files["grid.rou.xml"]).findall("vehicle")
    assert len(vehicles) == pytest.approx(30, abs=3)
    assert all(0.0 <= float(vehicle.get("depart", "nan")) < 60.0 for vehicle in vehicles)
    assert b"<!--" not in files["grid.rou.xml"]
    assert files == made(nets["grid"], tmp_path / "b")
    assert files["grid.rou.xml"] != made(nets["grid"], tmp_path / "c", seed=2)["grid.rou.xml"]


def test_single_road_has_traffic_and_runs(
    nets: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demand", str(nets["single"]), "--period", "2", "--duration", "60"]) == 0
    assert "gpsec run single/single.sumocfg" in capsys.readouterr().out
    assert cli.main(["run", "single/single.sumocfg", "--duration", "20", "--out", "results"]) == 0
    assert len((tmp_path / "results" / "vehicles.csv").read_text().splitlines()) > 5


def test_crash_of_the_tools_is_none_of_the_nets_fault(
    nets: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    killed = subprocess.CompletedProcess([], -signal.SIGSEGV, "", "")
    monkeypatch.setattr(trips, "run_tool", lambda *arguments: killed)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demand", str(nets["grid"])]) == 1
    assert capsys.readouterr().err.endswith(": randomTrips.py ended early (SIGSEGV: a fault of its own)\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere.net.xml"], ("nowhere.net.xml", "no such net file")),
        (["broken.net.xml"], ("broken.net.xml", "not a SUMO net")),
        (["city.osm"], ("city.osm: expected a net of SUMO, found an OpenStreetMap", "gpsec import city.osm")),
        (["city.osm.gz"], ("found an OpenStreetMap extract", "gpsec import city.osm.gz")),
        (["city.osm.bz2"], ("found an OpenStreetMap extract", "gpsec import city.osm.bz2")),
        (["city.osm.pbf"], ("found an OpenStreetMap extract", "gpsec import city.osm.pbf")),
        (["road.xodr"], ("road.xodr: expected a net of SUMO, found an OpenDRIVE map", "gpsec import road.xodr")),
        (["single.net.xml", "--out", "taken"], ("taken/single.sumocfg", "--overwrite")),
        (["single.net.xml", "--out", "broken.net.xml"], ("broken.net.xml", "found a file")),
        (["single.net.xml", "--out", "no/where"], ("no/where", "no folder no")),
        (["single.net.xml", "--out", "/proc/demand"], ("/proc/demand", "written")),
        (["single.net.xml", "--period", "0"], ("--period",)),
        (["single.net.xml", "--duration", "soon"], ("--duration", "number")),
        (["single.net.xml", "--seed", "-1"], ("--seed",)),
    ],
)
def test_refused(
    arguments: list[str],
    says: tuple[str, ...],
    nets: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "single.net.xml").write_bytes(nets["single"].read_bytes())
    (tmp_path / "broken.net.xml").write_text("<net")
    osm = b'<?xml version="1.0"?><osm version="0.6"><node id="1" lat="52" lon="10"/></osm>'
    for suffix, pack in (("", bytes), (".gz", gzip.compress), (".bz2", bz2.compress), (".pbf", bytes)):
        (tmp_path / f"city.osm{suffix}").write_bytes(pack(osm) if suffix != ".pbf" else b"\0\0\0\x0d")
    (tmp_path / "road.xodr").write_text("<OpenDRIVE><header/></OpenDRIVE>")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "single.sumocfg").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    assert cli.main(["demand", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1, captured.err
    assert all(fragment in captured.err for fragment in says), captured.err
    assert captured.out == ""
    assert sorted(tmp_path.rglob("*")) == before
