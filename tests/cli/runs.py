"""What stands in the place of a run while the command line is tested."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.progress import Progress
from gpsec.outcomes.tables import TABLES
from gpsec.scenario import Scenario


def write_results(scenario: Scenario, folder: Path) -> None:
    for table in TABLES:
        (folder / f"{table}.csv").write_text(f"scenario,seed\n{scenario.name},{scenario.seed}\n")
    (folder / "manifest.json").write_text(json.dumps({"scenario": scenario.name}))


def fake_run(scenario: Scenario, folder: Path, report: Callable[[Progress], None]) -> None:
    """Stands in for the pipeline, in a process of its own."""
    report(Progress(scenario.name, 1.0, 2.0, vehicles=3, tracks=12, real_time_factor=20.0, note="step lowered"))
    print("SUMO's chatter")
    if scenario.name == "refused":
        raise GpsecError("refused.net.xml: expected drivable lanes, found none")
    if scenario.name == "faulty":
        raise ZeroDivisionError("by hand")
    if scenario.name == "killed":
        (folder / "detection.csv").write_text("half")
        os.kill(os.getpid(), signal.SIGKILL)
    write_results(scenario, folder)


def make(parent: Path, name: str, toml: str = "") -> Path:
    folder = parent / name
    folder.mkdir()
    (folder / f"{name}.sumocfg").write_text("<sumoConfiguration/>")
    (folder / "gpsec.toml").write_text(toml)
    return folder


def never_run(*arguments: object) -> None:
    raise AssertionError("a bad input was run")


def sentence(capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line that an error prints."""
    captured = capsys.readouterr()
    assert captured.err.startswith("gpsec: error: ")
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    return captured.err
