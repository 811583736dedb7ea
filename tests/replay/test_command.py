"""`gpsec replay` as a command: folders, pages, going on, looking again; and a bad log leaves nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from gpsec.types.tapes import read_tape

from .logs import csv_log, table, way, write

SETS = (
    "fleet.settle_s=5",
    "detection.detectors=[]",
    "defences=[]",
    "outcomes.bootstrap=10",
    'plans=[{attack="drift",share=1.0,start_after_s=[2,4],duration_s=[8,8]}]',
)


def gpsec(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "gpsec", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=False,
    )


def replay(folder: Path, *more: str) -> subprocess.CompletedProcess[str]:
    sets = [part for text in SETS for part in ("--set", text)]
    logs = ("one.csv", "two.csv")
    return gpsec(folder, "replay", *logs, "--out", "out", "--copies", "2", "--profile", "carla", *sets, *more)


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("command")
    for seed, name in enumerate(("one", "two"), start=1):
        write(table(way(25.0), seed=seed), folder / f"{name}.csv")
    run = replay(folder)
    assert run.returncode == 0, run.stderr
    assert "error statistics" in run.stderr
    return folder


def test_a_folder_has_all_of_both_logs(done):
    names = {path.name for path in (done / "out").iterdir()}
    assert {"errors.csv", "log.html", "report.html", "events.csv", "gnss.tape-one.npz", "gnss.tape-two.npz"} <= names
    assert set(pd.read_csv(done / "out" / "errors.csv")["scenario"]) == {"one", "two"}
    assert set(pd.read_csv(done / "out" / "events.csv")["scenario"]) == {"one", "two"}
    assert read_tape(done / "out" / "gnss.tape-two.npz")[0].kind == "gnss"
    assert gpsec(done, "verify", "out").returncode == 0


def test_what_is_there_is_not_run_again(done):
    before = (done / "out" / "manifest.json").stat().st_mtime_ns
    run = replay(done, "--resume")
    assert run.returncode == 0, run.stderr
    assert "running" not in run.stderr
    assert (done / "out" / "manifest.json").stat().st_mtime_ns == before
    assert "holds another run; give --overwrite" in replay(done).stderr


def test_a_vehicle_of_a_log_can_be_looked_at_again(done):
    run = gpsec(done, "trace", "out", "two-1")
    assert run.returncode == 0, run.stderr
    assert (done / "out" / "trace-two-1.html").is_file()


def test_a_bad_log_ends_with_2_and_writes_nothing(tmp_path):
    columns = table()
    columns.loc[100, "t_s"] = 0.0
    csv_log(tmp_path, columns)
    run = gpsec(tmp_path, "replay", "drive.csv", "--out", "out")
    assert run.returncode == 2
    assert run.stderr.startswith("gpsec: error: ")
    assert "expected times that ascend" in run.stderr
    assert run.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["drive.csv"]
