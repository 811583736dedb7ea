"""Local workers: what fails is listed and run again alone, who is killed loses nothing, bytes are the same."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.core.progress import Progress
from gpsec.outcomes.tables import TABLES
from gpsec.running import workers
from gpsec.running.task_process import UnfitError
from gpsec.sweeps import work
from gpsec.sweeps.desk import run_as_listed
from gpsec.sweeps.folder import SweepFolder, write_list
from gpsec.sweeps.listing import listed
from gpsec.sweeps.plan import read_plan
from gpsec.sweeps.store import Store
from gpsec.sweeps.work import failed, forget_failures, missing, work_through

from .fake import content, fake_run, nothing_left, plan_of, slow_run

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def nothing_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "compile_kernels", lambda *arguments: None)


def make(folder: Path, seeds: str) -> SweepFolder:
    folder.mkdir(exist_ok=True)
    path = plan_of(folder, seeds)
    return write_list(folder / "made", listed(read_plan(path), path), {}, None)


def quiet(progress: Progress) -> None:
    return


def test_what_fails_is_listed_and_run_again_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = make(tmp_path, "12-13")
    told: list[Progress] = []
    worked = work_through(sweep, missing(sweep), 2, told.append, fake_run)
    (failure,) = worked.failures
    assert failure.sentence == "thirteen.net.xml: expected lanes, found none"
    assert len(content(sweep.store.path)) == len(TABLES) + 1
    assert nothing_left(sweep.store.path)
    assert {one.stage for one in told if "seed=13" in one.scenario} == {"running", "failed"}
    assert cli.main(["sweep", "--status", str(sweep.path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{sweep.path}: 1 of 2 done, 0 running, 1 failed"
    assert lines[1].startswith("failed: first slow_curve seed=13: thirteen.net.xml: expected lanes, found none (")
    log = Path(lines[1].rpartition("(")[2].rstrip(")"))
    assert "failed: thirteen.net.xml" in log.read_text()
    # Others do not try it again, until it is asked for.
    assert missing(sweep) == failed(sweep)
    assert work_through(sweep, missing(sweep), 2, quiet, slow_run).failures[0].sentence == failure.sentence
    assert not (tmp_path / "began").exists()
    forget_failures(sweep, failed(sweep))
    work_through(sweep, missing(sweep), 2, quiet, slow_run)
    assert [path.name.partition("-")[0] for path in (tmp_path / "began").iterdir()] == ["13"]


def test_a_longer_plan_runs_what_is_new(tmp_path: Path) -> None:
    sweep = make(tmp_path, "1-2")
    work_through(sweep, missing(sweep), 2, quiet, fake_run)
    longer = make(tmp_path, "1-5")
    assert len(longer.labels) == 5
    assert len(missing(longer)) == 3


def test_sweeps_share_a_store(tmp_path: Path) -> None:
    path = plan_of(tmp_path, "1-2")
    made = [
        write_list(tmp_path / name, listed(read_plan(path), path), {}, tmp_path / "common") for name in ("one", "two")
    ]
    work_through(made[0], missing(made[0]), 2, quiet, fake_run)
    assert missing(made[1]) == []


def test_a_run_whose_input_has_changed_since_it_was_listed_is_refused(tmp_path: Path) -> None:
    sweep = make(tmp_path, "1")
    (fingerprint,) = sweep.labels
    text = (sweep.path / "sweep.jsonl").read_text()
    (sweep.path / "sweep.jsonl").write_text(text.replace(fingerprint, "0" * 64))
    from gpsec.sweeps.folder import read_folder

    other = read_folder(sweep.path)
    with pytest.raises(UnfitError, match="expected what was listed, found other code, libraries or input"):
        work_through(other, missing(other), 1, quiet, run_as_listed)
    assert nothing_left(sweep.store.path)


WORKER = """
import sys
sys.path.insert(0, {root!r})
from pathlib import Path
from gpsec.sweeps import work
from gpsec.sweeps.folder import read_folder
from tests.sweeps.fake import slow_run
work.compile_kernels = lambda *arguments: None
sweep = read_folder(Path(sys.argv[1]))
work.work_through(sweep, work.missing(sweep), 1, lambda progress: None, slow_run)
"""


@pytest.fixture
def started() -> Iterator[list[subprocess.Popen[bytes]]]:
    processes: list[subprocess.Popen[bytes]] = []
    yield processes
    for process in processes:
        process.kill()
        process.wait()


def start(sweep: SweepFolder, processes: list[subprocess.Popen[bytes]]) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-c", WORKER.format(root=str(ROOT)), str(sweep.path)]
    processes.append(subprocess.Popen(command, cwd=ROOT))
    return processes[-1]


def wait_until(there: Path, count: int) -> None:
    until = time.monotonic() + 120.0
    while not there.exists() or len(list(there.iterdir())) < count:
        assert time.monotonic() < until
        time.sleep(0.02)


def test_a_worker_that_is_killed_loses_nothing(tmp_path: Path, started: list[subprocess.Popen[bytes]]) -> None:
    whole = make(tmp_path / "whole", "1-3")
    work_through(whole, missing(whole), 2, quiet, fake_run)
    sweep = make(tmp_path / "killed", "1-3")
    victim = start(sweep, started)
    wait_until(tmp_path / "killed" / "began", 1)
    os.kill(victim.pid, signal.SIGKILL)
    victim.wait()
    # Another one takes over what it had begun, at once: on the same machine its lock has fallen.
    began = time.monotonic()
    work_through(sweep, missing(sweep), 1, quiet, slow_run)
    assert time.monotonic() - began < 60.0
    assert content(sweep.store.path) == content(whole.store.path)
    assert nothing_left(sweep.store.path)


def test_two_workers_run_each_once(tmp_path: Path, started: list[subprocess.Popen[bytes]]) -> None:
    sweep = make(tmp_path, "1-4")
    processes = [start(sweep, started) for _ in range(2)]
    assert [process.wait(timeout=300) for process in processes] == [0, 0]
    assert missing(sweep) == []
    seeds = [path.name.partition("-")[0] for path in (tmp_path / "began").iterdir()]
    assert sorted(seeds) == ["1", "2", "3", "4"]
    assert nothing_left(sweep.store.path)


def test_claims(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path / "store")
    store.make()
    claim = store.claim("a" * 64)
    assert claim is not None
    assert store.claim("a" * 64) is None
    assert store.claimed("a" * 64)
    place = tmp_path / "store" / ".claims" / ("a" * 64)
    # One of another machine is alive as long as it is touched.
    place.write_text(place.read_text().replace('"machine": "', '"machine": "other '))
    claim._lock.close()
    assert store.claim("a" * 64) is None
    os.utime(place, (time.time() - 1000.0,) * 2)
    assert not store.claimed("a" * 64)
    taken = store.claim("a" * 64)
    assert taken is not None
    assert not claim.work.exists()
    taken.made.mkdir()
    (taken.made / "manifest.json").write_text("{}")
    store.publish(taken)
    assert store.has("a" * 64)
    assert nothing_left(store.path)


def test_a_run_that_was_made_twice_is_there_once(tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    store.make()
    shutil.copytree(_made(store, "b" * 64), store.result("b" * 64))
    claim = store.claim("b" * 64)
    assert claim is not None
    claim.made.mkdir()
    (claim.made / "manifest.json").write_text("{}")
    store.publish(claim)
    assert [path.name for path in store.result("b" * 64).iterdir()] == ["manifest.json"]


def _made(store: Store, fingerprint: str) -> Path:
    folder = store.path.with_name("made")
    folder.mkdir()
    (folder / "manifest.json").write_text("{}")
    return folder


def test_a_process_that_cannot_be_started_fails_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(workers, "TaskProcess", refuse)
    sweep = make(tmp_path, "1-2")
    worked = work_through(sweep, missing(sweep), 1, quiet, fake_run)
    assert len(worked.failures) == 2
    assert nothing_left(sweep.store.path)


PART = """
from typing import ClassVar

from gpsec.attacks.constant_bias import ConstantBias


class Mine(ConstantBias):
    name: ClassVar[str] = "mine"
"""


def test_a_part_that_the_workers_do_not_have(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(PART)
    path = plan_of(tmp_path, "1")
    path.write_text(f'parts = ["mine.py:Mine"]\nset.plans = [{{ attack = "mine", bias_m = 1.0 }}]\n{path.read_text()}')
    command = [sys.executable, "-m", "gpsec", "sweep"]
    listing = [*command, str(path), "--list", "--out", str(tmp_path / "made")]
    done = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True)
    assert "parts: 'mine.py:Mine' is code, and a plan may come from somebody else; --allow-code runs it" in done.stderr
    subprocess.run([*listing, "--allow-code"], cwd=ROOT, check=True)
    worker = [*command, "--worker", str(tmp_path / "made")]
    said = "gpsec: error: first slow_curve seed=1: parts: cannot be used on this machine: "
    done = subprocess.run(worker, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "mine.py:Mine' is code, and a scenario may come from somebody else" in done.stderr.partition(said)[2]
    (tmp_path / "mine.py").unlink()
    done = subprocess.run([*worker, "--allow-code"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "cannot be read: No such file" in done.stderr.partition(said)[2]
    assert nothing_left(tmp_path / "made" / "store")
