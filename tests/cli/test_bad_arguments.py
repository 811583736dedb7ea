"""What is wrong with arguments is one sentence, and nothing is written."""

from pathlib import Path

import pytest

from gpsec import cli
from gpsec.running import batch

from .runs import make, never_run, sentence

BAD_ARGUMENTS = {
    "no command": (["rnu"], ["no such command 'rnu'", "did you mean 'run'?"]),
    "unknown option": (["run", "town", "--sed", "1"], ["--sed", "did you mean", "--seed"]),
    "no scenario": (["run"], ["missing argument", "SCENARIO"]),
    "text for --seed": (["run", "town", "--seed", "x"], ["--seed", "integer"]),
    "negative --seed": (["run", "town", "--seed", "-1"], ["--seed -1: seed: expected at least 0"]),
    "--duration": (["run", "town", "--duration", "-5"], ["--duration -5.0: duration_s: expected more than 0"]),
    "--profile": (["run", "town", "--profile", "carlo"], ["--profile carlo: fleet.profile", "did you mean 'carla'?"]),
    "--engine": (["run", "town", "--engine", "refrence"], ["--engine refrence: engine", "did you mean 'reference'?"]),
    "--threads": (["run", "town", "--threads", "0"], ["--threads 0: threads: expected at least 1"]),
    "--jobs": (["run", "town", "--jobs", "0"], ["--jobs"]),
    "--set without value": (["run", "town", "--set", "seed"], ["--set seed: expected key=value"]),
    "--set of an unknown key": (["run", "town", "--set", "sed=1"], ["--set sed=1: unknown key 'sed'", "'seed'"]),
    "--set out of range": (["check", "town", "--set", "traffic.step_s=1"], ["--set traffic.step_s=1: traffic.step_s"]),
    "no such scenario": (["run", "tonw"], ["tonw: no such file or folder", "did you mean 'town'?"]),
    "bare name": (["run", "hill"], ["hill: no such file or folder; did you mean 'scenarios/hill'?"]),
    "other file": (["run", "notes.md"], ["notes.md: expected a scenario folder", "found a file '.md'"]),
    "empty folder": (["check", "empty"], ["empty: expected a gpsec.toml or one .sumocfg, found neither"]),
    "folder of scenarios": (["run", "scenarios"], ["found neither", "hill"]),
    "two sumocfgs": (["run", "two"], ["two: expected one .sumocfg, found a.sumocfg, b.sumocfg"]),
    "no sumocfg": (["run", "none"], ["none: expected one .sumocfg, found none"]),
    "same name twice": (["run", "town", "town/town.sumocfg"], ["'town' has the name of town"]),
    "out is a file": (["run", "town", "--out", "notes.md"], ["notes.md: expected an output folder, found a file"]),
    "out below a file": (["run", "town", "--out", "notes.md/x"], ["notes.md/x: no results can be written there"]),
    "out holds a run": (["run", "town", "--out", "done"], ["done: holds another run; give --overwrite"]),
    "out is the root": (["run", "town", "--out", "/"], ["/: expected an output folder, found the root"]),
    "out is no run": (["run", "town", "--out", "town", "--overwrite"], ["town: expected an empty or new folder"]),
    "default out holds a run": (["run", "scenarios/hill"], ["results/hill: holds another run"]),
    "unknown kind": (["list", "atacks"], ["KIND", "did you mean 'attacks'?"]),
    "no scenarios to list": (["list", "scenarios", "--dir", "empty"], ["empty: expected folders with a gpsec.toml"]),
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_bad_arguments(
    case: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments, fragments = BAD_ARGUMENTS[case]
    for name in ("scenarios", "empty", "none", "two", "done", "results"):
        (here / name).mkdir()
    make(here, "town")
    make(here / "scenarios", "hill")
    for path in ("two/a.sumocfg", "two/b.sumocfg", "none/gpsec.toml", "notes.md", "done/manifest.json"):
        (here / path).touch()
    (here / "results" / "hill").mkdir()
    (here / "results" / "hill" / "manifest.json").touch()
    before = sorted(here.rglob("*"))
    monkeypatch.setattr(batch, "run_scenarios", never_run)
    assert cli.main(arguments) == 2
    said = sentence(capsys)
    assert all(fragment in said for fragment in fragments), said
    assert sorted(here.rglob("*")) == before
