"""Workers with SUMO below them, killed before it starts, while it runs and while tables are written."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gpsec
from gpsec.sweeps.folder import SweepFolder, read_folder
from gpsec.sweeps.work import missing
from gpsec.types.constants import MANIFEST

from .fake import SCENARIO, content, kill_when, nothing_left, parent_of

ROOT = Path(__file__).parents[2]
SAID = "said.txt"
PLAN = f"""
[set]
duration_s = 120.0
fleet.settle_s = 3.0
outcomes.bootstrap = 20
defences = [{{ detector = "cusum", response = "ukf" }}]

[[entries]]
name = "one"
scenarios = ["{SCENARIO}"]
seeds = [2]
"""


def below(folder: Path) -> list[int]:
    """Return the processes that print into a log of a sweep: those of its runs, and SUMO's below them."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if (place / "fd" / "1").readlink().is_relative_to(folder / "logs"):
                found.append(int(place.name))
        except OSError:
            continue
    return found


@pytest.mark.slow
def test_a_run_that_was_killed_again_and_again_has_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN)
    whole = gpsec.sweep(tmp_path / "plan.toml", tmp_path / "whole", jobs=1)
    (fingerprint,) = whole.folder.labels
    command = [sys.executable, "-m", "gpsec", "sweep"]
    subprocess.run([*command, str(tmp_path / "plan.toml"), "--list", "--out", str(tmp_path / "killed")], check=True)
    killed = read_folder(tmp_path / "killed")
    for sign in SIGNS:
        with (killed.path / SAID).open("w") as said:
            process = subprocess.Popen([*command, "--worker", str(killed.path), "--jobs", "1"], cwd=ROOT, stderr=said)
        until = time.monotonic() + 300.0
        while not sign(killed.path) and process.poll() is None:
            assert time.monotonic() < until
            time.sleep(0.01)
        process.kill()
        assert process.wait() == -signal.SIGKILL  # it was still at it
        while left := below(killed.path):
            assert time.monotonic() < until, left
            time.sleep(0.1)
        assert missing(killed) == [fingerprint]
    subprocess.run([*command, "--worker", str(killed.path), "--jobs", "1"], check=True, cwd=ROOT)
    assert nothing_left(killed.store.path)
    assert tables(killed) == tables(whole.folder)


def tables(sweep: SweepFolder) -> dict[str, bytes]:
    """Return the files of all runs, but for manifests, which have times in them."""
    return {name: data for name, data in content(sweep.store.path).items() if not name.endswith(MANIFEST)}


def runs(folder: Path) -> list[int]:
    """Return the processes of runs that have SUMO's below them."""
    processes = below(folder)
    return [parent for parent in map(parent_of, processes) if parent in processes]


@pytest.mark.slow
def test_workers_of_dask_and_all_of_it_killed_with_sumo_below(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    from gpsec.sweeps.on_dask import connected

    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN.replace("120.0", "30.0").replace("[2]", '"2-4"'))
    whole = gpsec.sweep(plan, tmp_path / "whole", jobs=1)
    killed, command = tmp_path / "killed", [sys.executable, "-m", "gpsec", "sweep", "--no-report"]
    process = subprocess.Popen([*command, str(plan), "--out", str(killed), "--scheduler", "local", "--jobs", "1"])
    until = time.monotonic() + 300.0
    while not runs(killed):
        assert time.monotonic() < until
        time.sleep(0.01)
    process.kill()  # scheduler and client at once
    process.wait()
    while below(killed):
        assert time.monotonic() < until
        time.sleep(0.1)
    sweep = read_folder(killed)
    assert len(missing(sweep)) == 3
    with connected("local", 1) as client:
        killer = kill_when(lambda: runs(killed))
        again = gpsec.sweep(plan, killed, client=client)
        killer.join()
    assert list(again.tasks["state"]) == ["done"] * 3
    assert nothing_left(sweep.store.path)
    assert not below(killed)
    assert tables(sweep) == tables(whole.folder)


def begun(folder: Path) -> bool:
    """Return whether a run is claimed; SUMO has not started."""
    return bool(list((folder / "store" / ".work").iterdir()))


def sumo_has_started(folder: Path) -> bool:
    """Return whether there is a process below that of the run."""
    return len(below(folder)) >= 2


def steps_are_made(folder: Path) -> bool:
    """Return whether the worker has said so last."""
    return bool(re.search(r"running: [1-9]", (folder / SAID).read_text()))


def tables_are_written(folder: Path) -> bool:
    return bool(list((folder / "store" / ".work").glob("*/*/*.csv")))


SIGNS = (begun, sumo_has_started, steps_are_made, tables_are_written)
