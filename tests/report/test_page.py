"""The page as text: complete, self-contained, and deaf to what names in a run say."""

import json
import re
import shutil
from html.parser import HTMLParser

import pytest

from gpsec.outcomes.digests import table_digests
from gpsec.report.make import write_report
from gpsec.report.page import _plotly, unpacked
from gpsec.running.results import load

from .conftest import EVIL, write_run


class Page(HTMLParser):
    """Elements with their attributes, and the text of tables' cells."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.cells, self.scripts, self._inside = [], [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self._inside = dict(attrs).get("id", "script") if tag == "script" else tag

    def handle_endtag(self, tag):
        self._inside = None

    def handle_data(self, data):
        if self._inside in {"th", "td"}:
            self.cells.append(data)
        elif self._inside:
            self.scripts.setdefault(self._inside, data)


@pytest.fixture(scope="module")
def text(run_folder, tmp_path_factory):
    path = write_report(load(run_folder), path=tmp_path_factory.mktemp("page") / "report.html")
    return path.read_text("utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


@pytest.fixture(scope="module")
def data(page):
    return json.loads(unpacked(page.scripts["data"]))


def test_nothing_is_loaded_from_anywhere(page, text):
    for tag, attrs in page.elements:
        for name in ("src", "href", "action", "data"):
            assert attrs.get(name, "data:").startswith(("data:", "#")), (tag, attrs)
    assert "default-src 'none'" in text
    assert "plotly.js v" in unpacked(page.scripts["plotly"])[:200]


def test_names_are_text_and_never_elements(page, text):
    assert not [tag for tag, _ in page.elements if tag == "img"]
    assert EVIL in page.cells
    assert "<img" not in text


def test_it_is_small_enough_to_send(text):
    assert len(text) < 3_000_000


def test_every_figure_has_a_place_and_something_to_say_where_it_is_empty(page, data):
    places = [attrs["id"] for tag, attrs in page.elements if tag == "figure"]
    assert sorted(places) == sorted(data["figures"])
    assert len(places) == 14
    assert all(figure["whyEmpty"] for figure in data["figures"].values())


@pytest.mark.parametrize(
    ("key", "attacks"),
    [
        ("outcomes", {"bias", "jamming", EVIL}),
        ("delay", {"bias"}),
        ("cost", {"bias"}),
        ("roc", {"bias", EVIL}),
        ("pr", {"bias", EVIL}),
        ("cross_track_error", {"bias", "jamming", EVIL}),
        ("along_track_error", {"bias", "jamming", EVIL}),
    ],
)
def test_figures_show_the_attacks_that_they_are_defined_for(data, key, attacks):
    series = data["figures"][key]["series"]
    assert {one["where"]["attack"] for one in series} - {"none"} == attacks
    assert {one["where"]["group"] for one in series} == {"lane · dsd"}


def test_values_by_hand(data):
    figures = data["figures"]
    delay = next(one for one in figures["delay"]["series"] if one["name"] == "cusum")
    assert (delay["x"], delay["y"]) == ([0, 0.5, 0.5], [0, 0.5, 1])  # both after five steps
    bars = [one for one in figures["outcomes"]["series"] if one["where"]["attack"] == "bias"]
    assert [one["name"] for one in bars] == ["line touched", "out of lane", "wrong way", "off road"]
    assert bars[1]["x"] == ["never+none", "cusum+ukf"]
    assert bars[1]["y"] == [1, 0]
    assert bars[1]["text"] == ["2 of 2", "0 of 2"]
    undefended = next(one for one in figures["cross_track_error"]["series"] if one["name"] == "never+none")
    assert undefended["y"] == pytest.approx([0, 2, 2, 2], rel=0.1, abs=0.01)


def test_the_map_is_in_metres_about_its_middle(data):
    series = {
        one["name"]: one for one in data["figures"]["map"]["series"] if one["where"].get("attack", "bias") == "bias"
    }
    road = series["lanes"]
    assert road["x"][:2] == pytest.approx([-50.0, 50.0], abs=1.0)
    assert road["y"][:2] == pytest.approx([0.0, 0.0], abs=2.0)  # the net's grid is turned a little against north
    assert series["attack began"]["x"] == pytest.approx([-30.0, -30.0], abs=1.0)  # 20 m of the 100 m lane
    assert series["seen by cusum"]["x"] == pytest.approx([-25.0, -25.0], abs=1.0)
    said = series["left its lane with never+none"]["text"][0]
    assert ", 2.6 s, 10.46528 52.2513" in said  # degrees east, then north
    heat = [one for one in series.values() if one["kind"] == "heat"]
    assert [one["where"]["defence"] for one in heat] == ["never+none"]
    assert heat[0]["name"] == "departures an hour driven: 600"  # two in two times 6 s
    assert heat[0]["x"][:2] == pytest.approx([-50.0, 50.0], abs=1.0)  # the whole street


def test_a_zone_is_drawn_under_its_own_attack_alone(data):
    zones = [one for one in data["figures"]["map"]["series"] if one["kind"] == "area"]
    assert [one["where"]["attack"] for one in zones] == [EVIL]


def test_vehicles_are_chosen_by_their_error_and_traced(data):
    vehicles = {one["where"]["vehicle"] for one in data["figures"]["trace_residual"]["series"]}
    assert {name.partition(":")[0] for name in vehicles} == {"worst", "median", "first missed"}
    statistics = data["figures"]["trace_statistics"]["series"]
    assert {"threshold", "cusum", "under attack"} <= {one["name"] for one in statistics}


def test_traces_that_are_not_known_are_said_to_be(tmp_path):
    folder = write_run(tmp_path / "quiet", log=False)
    data = json.loads(unpacked(Page(write_report(load(folder)).read_text("utf-8")).scripts["data"]))
    figure = data["figures"]["trace_path"]
    assert figure["series"] == []
    assert "gpsec trace" in figure["whyEmpty"]
    assert "gpsec report RUN --again" in figure["whyEmpty"]


def test_a_run_that_was_interrupted_says_so(run_folder, tmp_path):
    folder = shutil.copytree(run_folder, tmp_path / "part")
    stated = json.loads((folder / "manifest.json").read_text())
    stated["unfinished"] = [{"scenario": "town", "reason": "interrupted"}]
    (folder / "manifest.json").write_text(json.dumps(stated))
    text = write_report(load(folder)).read_text("utf-8")
    assert re.search(r"not complete:\s+town \(interrupted\)", text)


def test_the_verdict_counts_who_left_the_lane(page, text):
    """Four vehicles are attacked across the road, two under jamming: too few to tell a defence from none."""
    assert "Undefended, an attack would have put a vehicle out of its lane in 100 % of all cases" in text
    assert "4 vehicles, each counted once: the mean of its share of the 2 attacks" in text
    assert "No defence here can be told apart from none: with cusum+ukf it is 0 % to 100 %." in text
    assert "Apart: jamming leaves nothing to compare" in text
    assert "cusum" in page.cells


def test_the_same_run_gives_the_same_page(run_folder, tmp_path, text):
    again = write_report(load(run_folder), path=tmp_path / "again.html")
    assert again.read_text("utf-8") == text


def test_tables_that_were_changed_by_hand_are_named(run_folder, tmp_path):
    folder = shutil.copytree(run_folder, tmp_path / "edited")
    stated = json.loads((folder / "manifest.json").read_text())
    stated["tables"] = table_digests(folder)
    (folder / "manifest.json").write_text(json.dumps(stated))
    said = "Not as the run has written them"
    assert said not in write_report(load(folder)).read_text()
    (folder / "safety.csv").write_text((folder / "safety.csv").read_text().replace("True", "False") + "\n")
    (folder / "map.geojson").unlink()
    page = " ".join(write_report(load(folder)).read_text().split())
    assert f"{said}: safety.csv (changed); map.geojson (missing)." in page


def test_a_damaged_plotly_in_the_cache_is_packed_again(tmp_path, monkeypatch):
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path))
    first = _plotly()
    (kept,) = tmp_path.glob("plotly-*")
    whole = kept.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:], b""):
        kept.write_bytes(damaged)
        assert _plotly() == first
        assert kept.read_bytes() == whole


def test_the_page_says_what_filters_and_detectors_do_not_know(tmp_path, text):
    folder = write_run(tmp_path / "run", log=False)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["scenarios"][0]["configuration"]["world"] = {"gnss_white_factor": 1.5, "camera_factor": 1.0}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    assert "nothing: noise and map are as stated" in text
    assert "gnss_white_factor 1.5<" in write_report(load(folder)).read_text("utf-8").replace("\n", "")
