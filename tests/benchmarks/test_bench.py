"""The benchmark works; no time is held to anything."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sumolib

from benchmarks import bench, city
from benchmarks.__main__ import FIGURES, main
from benchmarks.city import City
from benchmarks.figures import Figure, Sample
from benchmarks.store import FigureStore
from benchmarks.synthetic_traffic import SyntheticTraffic, everybody
from gpsec.hdmap.map import load_map
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import Recording, record_traffic
from gpsec.traffic.session import SumoSession
from sumo_nets.demand import Demand

HAMLET = City("hamlet", 4, Demand(0.6, 0.3, 500.0, lane_power=0.7), 60)


@pytest.fixture(scope="module")
def hamlet(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A city of reduced size, built in a folder of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(city, "BUILT", tmp_path_factory.mktemp("built"))
        city.build(HAMLET)
        yield HAMLET


@pytest.fixture(scope="module")
def recording(hamlet: City) -> Recording:
    options = resolve_options(hamlet.sumocfg, seed=1)
    with SumoSession(options, load_map(options.net_file, ()).lane_index, everybody) as session:
        return record_traffic(session, 8.0)


def test_the_city_has_signals_priority_junctions_curves_and_roads_of_one_to_three_lanes(hamlet):
    net = sumolib.net.readNet(str(hamlet.sumocfg.with_name("city.net.xml")))
    assert {"traffic_light", "priority"} <= {node.getType() for node in net.getNodes()}
    assert {edge.getLaneNumber() for edge in net.getEdges(False)} == {1, 2, 3}
    assert any(len(edge.getShape()) > 10 for edge in net.getEdges(False))


def test_the_city_begins_with_its_traffic_and_keeps_it(recording):
    on_road = recording.on_road
    assert on_road[0] > 30
    assert abs(on_road - on_road[0]).max() <= 0.2 * on_road[0]
    assert recording.step_s[0] == 0.1


def test_a_city_is_built_once_and_again_when_it_changes(hamlet):
    stamp = hamlet.sumocfg.with_name("stamp")
    before = stamp.stat().st_mtime_ns
    city.build(hamlet)
    assert stamp.stat().st_mtime_ns == before
    stamp.write_text("another")
    city.build(hamlet)
    assert stamp.read_text() != "another"
    assert [path.name for path in city.BUILT.iterdir()] == ["hamlet"]


@pytest.mark.parametrize("count", [10, 500])
def test_synthetic_traffic_is_as_large_as_asked_and_its_vehicles_are_those_of_the_recording(hamlet, recording, count):
    traffic = SyntheticTraffic(recording, count, resolve_options(hamlet.sumocfg, seed=1), {}, everybody)
    at_once = recording.frame(0)
    places = {tuple(front) for front in at_once.front_m.tolist()}
    on_road: dict[int, str] = {}
    for frame in traffic.frames():
        for row in frame.left:
            del on_road[row]
        on_road |= {departure.row: departure.vehicle_id for departure in frame.departures}
        assert len(set(on_road.values())) == len(on_road)
        assert frame.rows.tolist() == sorted(on_road)
        assert len(frame.front_m) == len(frame.lane) == len(frame.rows)
        assert len(frame.rows) == pytest.approx(count, rel=0.1)
        if frame.step == 0:
            assert {tuple(front) for front in frame.front_m.tolist()} <= places
            assert np.isin(frame.lane, at_once.lane).all()


@pytest.mark.parametrize(
    ("goal", "at_least", "value", "met"),
    [(2.0, False, 2.0, True), (2.0, False, 2.1, False), (300.0, True, 299.0, False), (300.0, True, 300.0, True)],
)
def test_a_goal_is_met_up_to_its_bound(goal, at_least, value, met):
    assert Figure("key", "what", goal, at_least).met(value) is met
    assert Figure("key", "what").met(value) is None


def test_the_store_has_median_extremes_and_samples_and_keeps_other_figures(tmp_path):
    path = tmp_path / "results" / "bench.json"
    one, other = Figure("one", "what", 2.0), Figure("other", "what")
    first = FigureStore(path, (one, other), quick=False)
    for value in (3.0, 1.0, 5.0):
        first.add({"one": Sample(value, {"made_of": value})}, {"read": [value]})
    second = FigureStore(path, (one, other), quick=False)
    second.add({"other": Sample(np.float32(7.0), {"made_of": np.int64(7)})}, {})
    content = json.loads(path.read_text())
    entry = content["figures"]["one"]
    assert (entry["median"], entry["min"], entry["max"]) == (3.0, 1.0, 5.0)
    assert entry["samples"] == [3.0, 1.0, 5.0]
    assert entry["of"][0] == {"made_of": 3.0}
    assert (entry["goal"], entry["met"]) == ("≤ 2", False)
    assert content["figures"]["other"]["samples"] == [7.0]
    FigureStore(path, (one, other), quick=False).add({"one": Sample(1.5)}, {})
    content = json.loads(path.read_text())
    assert content["figures"]["one"]["samples"] == [1.5]
    assert content["figures"]["one"]["met"] is True
    FigureStore(path, (one, other), quick=True).add({"other": Sample(1.0)}, {})
    assert list(json.loads(path.read_text())["figures"]) == ["other"]


def test_every_figure_has_a_key_of_its_own():
    assert len({figure.key for figure in FIGURES}) == len(FIGURES)


def test_the_command_writes_what_it_measures(hamlet, monkeypatch, tmp_path):
    monkeypatch.setattr(bench, "SMALL_CITY", hamlet)
    path = tmp_path / "bench.json"
    assert main(["--quick", "--only", "startup_s", "--only", "peak_rss_mb", "--out", str(path)]) == 0
    content = json.loads(path.read_text())
    assert set(content["figures"]) == {"startup_s", "peak_rss_mb"}
    assert {"cpu", "cores", "libsumo", "numba", "numpy"} <= set(content["machine"])
    for entry in content["figures"].values():
        assert 0.0 < entry["min"] <= entry["median"] <= entry["max"]
        assert len(entry["samples"]) == 1


def test_an_unknown_figure_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--only", "startup"])
    assert ended.value.code == 2
    assert "startup_s" in capsys.readouterr().err


def test_a_failed_run_leaves_the_others_alone(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("benchmarks.startup.SCENARIO", Path("nowhere"))
    path = tmp_path / "bench.json"
    assert main(["--quick", "--only", "startup_s", "--out", str(path)]) == 1
    assert "nowhere" in capsys.readouterr().out
    assert not path.exists()
