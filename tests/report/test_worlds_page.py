"""The page of a run in closed loop: figures by hand, names that HTML must not believe, and files that are damaged."""

import json
import re
import shutil

import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.outcomes.tables import EFFECTS, WORLD_TABLES
from gpsec.report.make import write_report
from gpsec.report.page import unpacked
from gpsec.report.worlds_tables import effect_tables, sentences
from gpsec.running.results import load

from .conftest import EVIL
from .test_page import Page
from .worlds import NAME, write_worlds_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_worlds_run(tmp_path_factory.mktemp("worlds") / "run")


@pytest.fixture(scope="module")
def run(folder):
    return load(folder)


@pytest.fixture(scope="module")
def text(run, tmp_path_factory):
    return write_report(run, path=tmp_path_factory.mktemp("page") / "report.html").read_text("utf-8")


@pytest.fixture(scope="module")
def figures(text):
    return json.loads(unpacked(re.search(r'id="data">([^<]+)<', text)[1]))["figures"]


def test_the_table_has_each_world_and_its_difference_to_the_twin(run):
    """Undefended: 40 and 80 collisions in 1,000 km, 5 and 9 s of delay, where the twins have none, 1 and 3 s."""
    (table,) = effect_tables(run)
    assert table.group == NAME
    rows = {(row.attack, row.name): dict(zip(table.headings[2:], row.cells, strict=True)) for row in table.rows}
    undefended = [(cell.text, cell.small) for cell in table.rows[1].cells]
    assert undefended == [
        *[("continue", ""), ("2", ""), ("10", ""), ("0", "")],
        *[("60.0", "40.0 to 80.0"), ("+60.0", "40.0 to 80.0")],
        *[("0.050", "0.050 to 0.050"), ("0.000", "0.000 to 0.000")],
        *[("7.0", "5.0 to 9.0"), ("+5.0", "4.0 to 6.0")],
        *[("7.0", "7.0 to 7.0"), ("0.0", "0.0 to 0.0")],
    ]
    assert [cell.text for cell in table.rows[0].cells][4:6] == ["0.0", "–"]
    assert set(rows) == {("none", "never+none"), (EVIL, "never+none"), (EVIL, "cusum+ukf")}


def test_sentences_name_the_worst_and_the_best_and_few_seeds(run):
    first, second, few = sentences(run)[NAME]
    assert first.startswith(f"{EVIL}, undefended: +60.0 collisions per 1,000 vehicle-km (40.0 to 80.0), +5.0 s of")
    assert "with cusum+ukf: +5.0 collisions" in second
    assert "2 seeds are a first look, claims need 10" in few


def test_nothing_is_loaded_and_names_are_text(text):
    page = Page(text)
    for tag, attrs in page.elements:
        assert tag != "img"
        for name in ("src", "href", "action", "data"):
            assert attrs.get(name, "data:").startswith(("data:", "#")), (tag, attrs)
    assert EVIL in page.cells


def test_figures_show_the_worlds(figures):
    worlds = {series["where"]["world"]: series for series in figures["map"]["series"] if "world" in series["where"]}
    assert set(worlds) == {"never+none, continue", "cusum+ukf, continue"}
    named = [(one["name"], one["x"]) for one in figures["map"]["series"] if one["where"].get("attack") == EVIL]
    assert ("oncoming", [50, 52, 50, 52, 54, 56]) in named
    # The net is in its own coordinates: the lane goes from (0, 0) to (100, 0).
    (lanes,) = (one for one in figures["map"]["series"] if one["kind"] == "road")
    assert lanes["x"] == [0, 100, None]
    assert [abs(value) for value in lanes["y"][:2]] == [0, 0]


def test_the_road_is_that_of_the_seed_that_caused_most_standing(figures):
    """Seed 2 stood 40 s on the road, its twin 10 s."""
    labels = {one["where"]["world"] for one in figures["road"]["series"] if "never" in one["where"]["world"]}
    assert labels == {"never+none, continue: road -3, seed 2, +30 s of standing"}
    lines = [one for one in figures["road"]["series"] if one["kind"] == "line"]
    assert lines[0]["y"].count(None) == 1  # two vehicles
    assert {one["name"] for one in figures["road"]["series"]} >= {"under attack", "wreck, or stopped on an alarm"}


def test_the_story_of_a_crash_has_both_and_their_estimates(figures):
    label = "never+none, continue: oncoming at 9.0 s with 20.0 m/s, seed 1"
    path = [one for one in figures["crash_path"]["series"] if one["where"]["crash"] == label]
    assert [one["name"] for one in path] == [
        *(f"{EVIL}, truth", f"{EVIL}, estimate", f"{EVIL}, body"),
        *("b, truth", "b, body"),
    ]
    # The bodies touch at the crash, 2 m to both sides of it, and 4.5 m long.
    assert max(value for value in path[2]["x"] if value is not None) == pytest.approx(0.25)
    beside = {one["name"]: one for one in figures["crash_beside"]["series"] if one["where"]["crash"] == label}
    assert set(beside[f"{EVIL}, error of its estimate"]["y"]) == {-1.5}
    assert set(beside[f"{EVIL} is"]["y"]) == {1.5}
    assert beside[f"{EVIL} under attack"]["x"] == [-10, 0]


def test_a_damaged_table_is_one_sentence(folder, tmp_path, capsys):
    for name in (*WORLD_TABLES, EFFECTS):
        copy = shutil.copytree(folder, tmp_path / name)
        file = copy / f"{name}.csv"
        lines = file.read_text("utf-8").splitlines()
        head = lines[0].split(",")
        file.write_text("\n".join([lines[0], ",".join(["x"] * len(head))]) + "\n")
        assert cli.main(["report", str(copy)]) == 2
        (said,) = capsys.readouterr().err.splitlines()
        assert f"{name}.csv: column '" in said
        file.unlink()
        assert cli.main(["report", str(copy)]) == (0 if name == "worlds" else 2)
        capsys.readouterr()


def test_a_manifest_without_the_net_is_one_sentence(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    manifest = json.loads((copy / "manifest.json").read_text("utf-8"))
    manifest["scenarios"][0]["closed_loop"] = {"net": {"projection": "!", "offset_m": "far"}}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(GpsecError, match=r"closed_loop\.net: expected projection and offset_m of the net, found"):
        write_report(load(copy))
