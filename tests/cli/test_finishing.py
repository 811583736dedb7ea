"""What is left where scenarios finish, fail, or take the place of a former run."""

import json
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.console import aftermath
from gpsec.outcomes.tables import TABLES

from .runs import make


def test_finished_scenarios_survive_the_failure_of_others(
    here: Path, faked: None, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("town", "refused", "killed", "hill"):
        make(here, name)
    assert cli.main(["run", "town", "refused", "killed", "hill", "--out", "all", "--jobs", "2", "--seed", "9"]) == 1
    captured = capsys.readouterr()
    assert "gpsec: error: scenario 'refused': refused.net.xml: expected drivable lanes, found none\n" in captured.err
    assert "scenario 'killed': its process ended early (SIGKILL: most likely" in captured.err
    assert "town: step lowered" in captured.err
    assert "town: running: 1/2 s, 3 vehicles, 12 tracks, 20.0x real time" in captured.err
    assert "hill: done\n" in captured.err
    assert "refused: failed\n" in captured.err
    assert captured.out == "tables of all\n"  # what SUMO prints is not among it
    for table in TABLES:
        assert (here / "all" / f"{table}.csv").read_text() == "scenario,seed\nhill,9\ntown,9\n"
    unfinished = json.loads((here / "all" / "manifest.json").read_text())["unfinished"]
    assert [entry["scenario"] for entry in unfinished] == ["refused", "killed"]
    assert unfinished[0]["reason"] == "refused.net.xml: expected drivable lanes, found none"
    hidden = here / ".all.partial"  # to go on with
    assert sorted(path.name for path in hidden.iterdir()) == [".lock", "hill", "town"]


def test_one_refused_scenario_ends_with_status_2_and_writes_nothing(
    here: Path, faked: None, capsys: pytest.CaptureFixture[str]
) -> None:
    make(here, "refused")
    assert cli.main(["run", "refused"]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert not (here / "results").exists()


def test_a_fault_of_ours_shows_where_it_happened(here: Path, faked: None, capsys: pytest.CaptureFixture[str]) -> None:
    make(here, "faulty")
    assert cli.main(["run", "faulty"]) == 1
    said = capsys.readouterr().err
    assert "scenario 'faulty': fault in gpsec (ZeroDivisionError: by hand)" in said
    assert "in fake_run" in said


def test_overwrite_replaces_the_run_and_keeps_notes(here: Path, faked: None) -> None:
    make(here, "town")
    former = here / "results" / "town"
    former.mkdir(parents=True)
    for name in ("manifest.json", "steps.parquet", "notes.md"):
        (former / name).write_text("former")
    assert cli.main(["run", "town", "--overwrite"]) == 0
    found = {path.name for path in former.iterdir()}
    assert found == {*(f"{table}.csv" for table in TABLES), "manifest.json", "notes.md"}
    assert "unfinished" not in json.loads((former / "manifest.json").read_text())


def test_parquet_is_asked_for_by_format(here: Path, faked: None, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []
    monkeypatch.setattr(aftermath, "_write_parquet", written.append)
    make(here, "town")
    assert cli.main(["run", "town", "--out", "a"]) == 0
    assert written == []
    assert cli.main(["run", "town", "--out", "b", "--format", "parquet"]) == 0
    assert written == [here / "b"]
    assert cli.main(["run", "town", "--out", "c", "--format", "xlsx"]) == 2
