"""On a cluster: whoever is killed, and whatever one worker lacks, the bytes are those of an undisturbed run."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
import pytest

import gpsec
from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.core.progress import Progress
from gpsec.sweeps.folder import SweepFolder, read_folder
from gpsec.sweeps.work import missing, work_through
from gpsec.types.constants import MANIFEST

from .fake import SCENARIO, content, fake_run, kill_when, nothing_left, slow_run
from .test_work import make, quiet, wait_until

pytest.importorskip("distributed")

from gpsec.sweeps.on_dask import connected, work_on

ROOT = Path(__file__).parents[2]
Start = Callable[..., subprocess.Popen[bytes]]

CLIENT = """
import sys
sys.path.insert(0, {root!r})
from pathlib import Path
from gpsec.sweeps.folder import read_folder
from gpsec.sweeps.on_dask import connected, work_on
from gpsec.sweeps.work import missing
from gpsec.core.errors import GpsecError
from sweeps.fake import slow_run
sweep = read_folder(Path(sys.argv[1]))
try:
    with connected(sys.argv[2], 1) as client:
        work_on(client, sweep, missing(sweep), lambda progress: None, slow_run)
except GpsecError as error:
    sys.exit(str(error))
"""


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a module of Python in the background; what it starts goes with it."""
    processes: list[subprocess.Popen[bytes]] = []

    def begin(*arguments: str, path: Path = ROOT, limit: str = "") -> subprocess.Popen[bytes]:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (path, ROOT, ROOT / "tests")))}
        command = [sys.executable, *arguments]
        if limit:
            command = ["sh", "-c", f'{limit}; exec "$@"', "sh", *command]
        said = (tmp_path / f"said-{len(processes)}").open("wb")
        processes.append(
            subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=said, stdout=said, start_new_session=True)
        )
        return processes[-1]

    yield begin
    for process in processes:
        for number in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(process.pid, number)
            except ProcessLookupError:
                break
            if number == signal.SIGTERM:
                time.sleep(0.5)
        process.wait()


def scheduler(start: Start, folder: Path) -> tuple[subprocess.Popen[bytes], str]:
    file = folder / "scheduler.json"
    process = start(
        *("-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)),
        *("--host", "127.0.0.1"),
    )
    until = time.monotonic() + 180.0
    while not file.exists():
        assert time.monotonic() < until
        time.sleep(0.1)
    return process, str(json.loads(file.read_text())["address"])


def worker(start: Start, address: str, name: str, **more: object) -> subprocess.Popen[bytes]:
    return start(
        *("-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1", "--memory-limit", "0"),
        *("--no-dashboard", "--death-timeout", "60", "--name", name, "--host", "127.0.0.1"),
        **more,
    )


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return what an undisturbed local worker makes of three seeds."""
    sweep = make(tmp_path_factory.mktemp("whole"), "1-3")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gpsec.sweeps.work.compile_kernels", lambda *arguments: None)
        work_through(sweep, missing(sweep), 2, quiet, fake_run)
    return content(sweep.store.path)


def test_a_cluster_makes_the_same_bytes(tmp_path: Path, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    told: list[Progress] = []
    with connected("local", 2) as client:
        assert work_on(client, sweep, missing(sweep), told.append, fake_run).failures == []
        assert content(sweep.store.path) == expected
        assert nothing_left(sweep.store.path)
        assert sum(progress.stage == "done" for progress in told) == 3
        failing = make(tmp_path / "failing", "13-14")
        (failure,) = work_on(client, failing, missing(failing), quiet, fake_run).failures
        assert failure.sentence == "thirteen.net.xml: expected lanes, found none"
        assert len(missing(failing)) == 1
        # A worker that is killed takes its run with it, and another one makes that again.
        deadly = make(tmp_path / "deadly", "1-2")
        killer = kill_when(lambda: [int(at.name.partition("-")[2]) for at in (tmp_path / "deadly").glob("began/*")])
        assert work_on(client, deadly, missing(deadly), quiet, slow_run).failures == []
        killer.join()
    assert content(deadly.store.path).items() <= expected.items()
    assert missing(deadly) == []
    assert nothing_left(deadly.store.path)
    assert len(list((tmp_path / "deadly" / "began").iterdir())) == 3


def test_a_scheduler_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = make(tmp_path, "1")
    assert cli.main(["sweep", str(sweep.path), "--scheduler", "tcp://127.0.0.1:9"]) == 2
    line = capsys.readouterr().err.strip().splitlines()[-1]
    assert line.startswith(
        "gpsec: error: --scheduler tcp://127.0.0.1:9: expected a scheduler of Dask there, found none"
    )


@pytest.mark.slow
def test_a_worker_that_is_killed(tmp_path: Path, start: Start, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    _, address = scheduler(start, tmp_path)
    victim = worker(start, address, "victim")
    client = start("-c", CLIENT.format(root=str(ROOT)), str(sweep.path), address)
    wait_until(tmp_path / "began", 1)
    os.kill(victim.pid, signal.SIGKILL)
    worker(start, address, "heir")
    assert client.wait(timeout=300) == 0
    assert content(sweep.store.path) == expected
    assert nothing_left(sweep.store.path)


@pytest.mark.slow
def test_a_client_that_is_killed(tmp_path: Path, start: Start, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    _, address = scheduler(start, tmp_path)
    worker(start, address, "one")
    client = start("-c", CLIENT.format(root=str(ROOT)), str(sweep.path), address)
    wait_until(tmp_path / "began", 1)
    os.kill(client.pid, signal.SIGKILL)
    with connected(address, 1) as other:
        assert work_on(other, sweep, missing(sweep), quiet, slow_run).failures == []
    assert content(sweep.store.path) == expected
    assert nothing_left(sweep.store.path)


@pytest.mark.slow
def test_a_scheduler_that_is_killed(tmp_path: Path, start: Start, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    head, address = scheduler(start, tmp_path)
    worker(start, address, "one")
    client = start("-c", CLIENT.format(root=str(ROOT)), str(sweep.path), address)
    wait_until(tmp_path / "began", 1)
    os.kill(head.pid, signal.SIGKILL)
    assert client.wait(timeout=300) == 1
    assert any("the scheduler is gone; what is done is kept" in path.read_text() for path in tmp_path.glob("said-*"))
    work_through(sweep, missing(sweep), 1, quiet, slow_run)
    assert content(sweep.store.path) == expected
    assert nothing_left(sweep.store.path)


@pytest.mark.slow
def test_a_worker_whose_disk_is_full(tmp_path: Path, start: Start, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    _, address = scheduler(start, tmp_path)
    # No file of it may be as long as a table: what a full disk says, for this worker alone.
    worker(start, address, "full", limit="ulimit -f 64")
    worker(start, address, "whole")
    with connected(address, 1) as client:
        client.wait_for_workers(2, timeout=120)
        assert work_on(client, sweep, missing(sweep), quiet, fake_run).failures == []
    assert content(sweep.store.path) == expected
    assert nothing_left(sweep.store.path)


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(tmp_path: Path, start: Start, expected: dict[str, bytes]) -> None:
    sweep = make(tmp_path, "1-3")
    other = tmp_path / "other"
    shutil.copytree(ROOT / "gpsec", other / "gpsec", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("scenarios", "sumo_nets"):
        (other / name).symlink_to(ROOT / name)
    with (other / "gpsec" / "pipeline" / "loop.py").open("a") as file:
        file.write("# changed\n")
    _, address = scheduler(start, tmp_path)
    worker(start, address, "other", path=other)
    with connected(address, 1) as client:
        client.wait_for_workers(1, timeout=120)
        with pytest.raises(GpsecError, match=r"every worker is refused: tcp.* has other code or libraries"):
            work_on(client, sweep, missing(sweep), quiet, fake_run)
        worker(start, address, "same")
        client.wait_for_workers(2, timeout=120)
        told: list[Progress] = []
        assert work_on(client, read_folder(sweep.path), missing(sweep), told.append, fake_run).failures == []
    assert any("refused: has other code or libraries" in progress.note for progress in told)
    assert content(sweep.store.path) == expected


REAL = f"""
[set]
duration_s = 20.0
fleet.settle_s = 3.0
outcomes.bootstrap = 20

[[entries]]
name = "real"
scenarios = ["{SCENARIO}"]
seeds = "1-4"
"""


@pytest.mark.slow
def test_real_runs_on_a_cluster_have_the_bytes_of_local_ones(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(REAL)
    here = gpsec.sweep(tmp_path / "plan.toml", tmp_path / "here", jobs=1)
    with connected("local", 2) as client:
        there = gpsec.sweep(tmp_path / "plan.toml", tmp_path / "there", client=client)
    assert list(there.tasks["state"]) == ["done"] * 4
    assert nothing_left(there.folder.store.path)
    one, other = (
        {name: data for name, data in content(sweep.folder.store.path).items() if not name.endswith(MANIFEST)}
        for sweep in (here, there)
    )
    assert one == other
    pd.testing.assert_frame_equal(here.safety, there.safety)


def test_dask_that_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep: SweepFolder = make(tmp_path, "1")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert cli.main(["sweep", str(sweep.path), "--scheduler", "local"]) == 2
    assert "expected Dask, found it is not installed" in capsys.readouterr().err
