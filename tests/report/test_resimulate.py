"""Vehicles that are simulated again do what they did."""

import re
from pathlib import Path

import pandas as pd
import pytest

from gpsec import cli
from gpsec.console import resimulation
from gpsec.core.errors import GpsecError
from gpsec.pipeline.run import run_scenario
from gpsec.report.make import trace_page
from gpsec.report.resimulate import found_from, simulate
from gpsec.report.stories import choose_stories, story_of
from gpsec.running.results import load
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

from .conftest import EVIL, write_run

CHANGES = (
    "duration_s=40",
    "fleet.settle_s=4",
    "fleet.equipped_share=0.5",
    "outcomes.bootstrap=20",
    'plans=[{attack="constant_bias", share=0.7, start_after_s=[0.0, 4.0], duration_s=[4.0, 8.0]}]',
    'detection.detectors=["chi_square", "cusum"]',
    'defences=[{detector="cusum", response="ukf"}]',
)


@pytest.fixture(scope="module")
def logged(repository, tmp_path_factory):
    """A run that has logged all steps."""
    folder = tmp_path_factory.mktemp("logged")
    scenario = load_scenario(
        repository / "scenarios" / "slow_curve", [parse_set(change) for change in (*CHANGES, "log_steps=true")]
    )
    run_scenario(scenario, folder, lambda progress: None)
    return load(folder)


def test_chosen_vehicles_alone_are_the_same_to_the_last_bit(logged):
    vehicles = sorted({story.vehicle_id for story in choose_stories(logged)})
    found = simulate(logged, {"slow_curve": vehicles}, lambda progress: None)["slow_curve"]
    expected = logged.steps("slow_curve", vehicles)
    assert set(expected["plan"]) == {"none", "constant_bias"}
    keys = ["vehicle_id", "plan", "time_s"]
    a, b = (steps.sort_values(keys, ignore_index=True) for steps in (found, expected))
    last = a["time_s"].max()  # it ends once these vehicles have left
    pd.testing.assert_frame_equal(a, b[b["time_s"] <= last].reset_index(drop=True), check_exact=True)


@pytest.mark.parametrize(
    "camera",
    [('fleet.camera.visibility="place"',), ('fleet.camera.source="image"', "fleet.camera.image_share=0.1")],
    ids=["by place", "pictures"],
)
def test_cameras_that_see_other_vehicles_have_them_about(repository, tmp_path, camera):
    sets = (*CHANGES, "duration_s=25", "log_steps=true", *camera)
    scenario = load_scenario(repository / "scenarios" / "slow_curve", [parse_set(change) for change in sets])
    run_scenario(scenario, tmp_path, lambda progress: None)
    run = load(tmp_path)
    seeing = sorted(run.manifest("slow_curve")["pixels"].get("vehicles", {}))
    vehicles = (seeing or sorted(run.vehicles["vehicle_id"].unique()))[:3]
    assert vehicles
    found = simulate(run, {"slow_curve": vehicles}, lambda progress: None)["slow_curve"]
    keys = ["vehicle_id", "plan", "time_s"]
    a, b = (steps.sort_values(keys, ignore_index=True) for steps in (found, run.steps("slow_curve", vehicles)))
    pd.testing.assert_frame_equal(a, b[b["time_s"] <= a["time_s"].max()].reset_index(drop=True), check_exact=True)


def unattacked(run):
    """Vehicles without an event."""
    return [name for name in run.vehicles["vehicle_id"].unique() if name not in set(run.events["vehicle_id"])]


def test_vehicles_that_were_never_attacked_are_simulated_again(logged):
    vehicle = unattacked(logged)[0]
    found = simulate(logged, {"slow_curve": [vehicle]}, lambda progress: None)["slow_curve"]
    expected = logged.steps("slow_curve", [vehicle])
    assert len(expected) > 50
    assert set(found["plan"]) == {"none"}
    begins = expected["time_s"].reset_index(drop=True)[: len(found)]
    pd.testing.assert_series_equal(found["time_s"], begins, check_exact=True)


def test_another_life_of_an_unattacked_vehicle_is_noticed(logged, monkeypatch):
    monkeypatch.setitem(logged.tables, "vehicles", logged.vehicles.assign(rmse_xy_m=1.0))
    with pytest.raises(GpsecError, match="do not do what they did in this run"):
        simulate(logged, {"slow_curve": [unattacked(logged)[0]]}, lambda progress: None)


def test_the_trace_of_an_unattacked_vehicle_is_told(logged, capsys: pytest.CaptureFixture[str]):
    vehicle = unattacked(logged)[0]
    assert cli.main(["trace", str(logged.folder), vehicle]) == 0
    assert f"{vehicle} (slow_curve · dsd), without an attack" in capsys.readouterr().out


def test_another_code_or_traffic_is_noticed(logged, monkeypatch):
    monkeypatch.setitem(logged.tables, "events", logged.events.assign(start_s=1.0))
    vehicle = logged.events["vehicle_id"].iloc[0]
    with pytest.raises(GpsecError, match="do not do what they did in this run"):
        simulate(logged, {"slow_curve": [vehicle]}, lambda progress: None)


def test_traffic_that_is_gone_is_said(run):
    with pytest.raises(GpsecError, match=r"lane' (cannot be run here|is not there)"):
        simulate(run, {"lane": ["b"]}, lambda progress: None)


def test_a_story_on_the_terminal(run_folder, capsys: pytest.CaptureFixture[str]):
    assert cli.main(["trace", str(run_folder), EVIL]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "under bias from 2.1 to 6.1 s" in said
    assert "after 0.5 s" in said
    assert "off road after 0.5 s" in said or "out of lane after 0.5 s" in said
    pages = [path.name for path in run_folder.glob("trace-*.html")]
    assert pages == [trace_page(EVIL)]
    assert "<img" not in (run_folder / pages[0]).read_text("utf-8")


def test_pages_of_two_vehicles_have_two_names():
    assert trace_page("a_b") == "trace-a_b.html"
    assert len({trace_page(name) for name in ("a_b", "a/b", "a b", "a__b", "x" * 101, "x" * 102)}) == 6
    assert all(re.fullmatch(r"trace-[\w.-]{1,109}\.html", trace_page(name)) for name in (EVIL, "a/b", "x" * 300))


def test_stories_are_asked_for_by_name(run):
    assert story_of(run, "b").attack == "bias"
    assert story_of(run, "b", attack="none").start_s == pytest.approx(0.0)
    for ask, said in (
        (lambda: story_of(run, "bb"), "no vehicle 'bb' in this run; did you mean 'b'?"),
        (lambda: story_of(run, "b", attack="jam"), "vehicle 'b' was not under 'jam'"),
        (lambda: story_of(run, "b", scenario="town"), "no scenario 'town'"),
    ):
        with pytest.raises(GpsecError) as caught:
            ask()
        assert said in str(caught.value)


def test_the_chosen_are_the_worst_the_median_and_the_first_missed(run):
    stories = {story.why: story for story in choose_stories(run)}
    # CUSUM+UKF: nobody is off by more than 0.05 m but for the order of their names; the bias alone is seen.
    assert list(stories) == ["worst", "median", "first missed"]
    assert stories["first missed"].attack != "bias"
    assert not stories["first missed"].events.query("defence == 'cusum+ukf'")["detected"].any()


def test_a_report_from_the_command_line(run_folder, tmp_path, capsys: pytest.CaptureFixture[str]):
    assert cli.main(["report", str(run_folder), "--out", str(tmp_path / "page.html"), "--geojson"]) == 0
    assert capsys.readouterr().out.splitlines() == [str(tmp_path / "page.html"), str(run_folder / "places.geojson")]
    assert cli.main(["report", str(tmp_path)]) == 2
    assert "found no manifest.json in it" in capsys.readouterr().err


def test_a_report_runs_sumo_only_when_asked(tmp_path, monkeypatch, capsys: pytest.CaptureFixture[str]):
    folder = write_run(tmp_path / "received", log=False)
    asked = []

    def noted(run, wanted, tell):
        asked.append(dict(wanted))
        raise GpsecError("not here")

    monkeypatch.setattr(resimulation, "simulate", noted)
    assert cli.main(["report", str(folder)]) == 0
    assert asked == []
    assert cli.main(["report", str(folder), "--again"]) == 2  # the page is written all the same
    assert [list(wanted) for wanted in asked] == [["lane"]]
    assert "gpsec: no traces: not here" in capsys.readouterr().err
    assert (folder / "report.html").is_file()


def test_traffic_is_found_from_any_folder(tmp_path, monkeypatch):
    (tmp_path / "scenarios" / "lane").mkdir(parents=True)
    (tmp_path / "scenarios" / "lane" / "lane.sumocfg").touch()
    run, named = tmp_path / "results" / "lane", Path("scenarios/lane/lane.sumocfg")
    run.mkdir(parents=True)
    assert found_from(run, named) == tmp_path.resolve() / named
    monkeypatch.chdir(run)
    assert found_from(Path(), named) == tmp_path.resolve() / named
    assert found_from(run, Path("elsewhere.sumocfg")) is None
