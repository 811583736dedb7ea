"""Two runs never write into one folder, whichever folders they have besides."""

import fcntl
import shutil
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.console import aftermath
from gpsec.core.errors import GpsecError
from gpsec.running import batch, workshop
from gpsec.running.publishing import COMPLETE
from gpsec.running.workshop import occupied, settle, workshop_of, workshops


def make(parent: Path, *names: str) -> None:
    for name in names:
        (parent / name).mkdir()
        (parent / name / f"{name}.sumocfg").write_text("<sumoConfiguration/>")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def never_run(*arguments: object) -> None:
    raise AssertionError("a run began in a folder of another one")


@pytest.mark.parametrize("arguments", [["c", "b"], ["b", "c"], ["b"]])
def test_runs_that_have_one_folder_in_common(
    arguments: list[str], here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    make(here, "a", "b", "c")
    monkeypatch.setattr(batch, "run_scenarios", never_run)
    with workshops([here / "results" / "a", here / "results" / "b"]):
        assert cli.main(["run", *arguments]) == 2
        assert "results/b: another run is being written there" in capsys.readouterr().err
        assert [path.name for path in (here / "results").iterdir()] == [".a.partial", ".b.partial"]
    assert not (here / "results").exists()


def test_a_folder_is_ours_until_its_report_is_there(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gpsec.running.workers import Outcome

    make(here, "a", "b")
    refused: list[str] = []

    def others_come(folder: Path, *arguments: object) -> None:
        with pytest.raises(GpsecError, match="another run is being written there"), workshops([folder]):
            pass
        refused.append(folder.name)

    def publish(self: batch.Batch, folder: Path, *arguments: object) -> None:
        folder.mkdir()

    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: Outcome(["a", "b"]))
    monkeypatch.setattr(batch.Batch, "_publish", publish)
    monkeypatch.setattr(aftermath, "show_findings", others_come)
    monkeypatch.setattr(aftermath, "_report", others_come)
    assert cli.main(["run", "a", "b"]) == 0
    assert refused == ["a", "a", "b", "b"]


def test_what_is_refused_leaves_work_to_go_on_with(here: Path) -> None:
    """A former run was interrupted; the next one is refused, since the folder holds what had finished."""
    make(here, "a")
    kept = workshop_of(here / "results" / "a") / "a"
    kept.mkdir(parents=True)
    (here / "results" / "a").mkdir()
    (here / "results" / "a" / "manifest.json").touch()
    assert cli.main(["run", "a"]) == 2
    assert kept.is_dir()


def test_no_empty_folder_is_left(here: Path) -> None:
    with workshops([here / "a" / "b" / "out", here / "a" / "c"]) as works:
        assert all(work.folder.is_dir() for work in works.values())
    assert list(here.iterdir()) == []


def test_a_lock_that_went_with_its_folder_is_none(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run that held the lock ends, and removes its folder, between our opening the file and locking it."""
    folder = workshop_of(here / "out")
    real, calls = fcntl.flock, 0

    def flock(*arguments: int) -> None:
        nonlocal calls
        calls += 1
        if calls == 1:
            shutil.rmtree(folder)
        real(*arguments)

    monkeypatch.setattr(workshop.fcntl, "flock", flock)
    with (
        occupied(folder, here / "out"),
        pytest.raises(GpsecError, match="another run is being written there"),
        occupied(folder, here / "out"),
    ):
        pass
    assert calls > 2


def test_a_lock_that_leads_nowhere(here: Path) -> None:
    folder = workshop_of(here / "out")
    folder.mkdir()
    (folder / ".lock").symlink_to("nowhere/at/all")
    with pytest.raises(GpsecError, match="out: no results can be written there"), occupied(folder, here / "out"):
        pass


def test_a_reader_finishes_what_was_begun(here: Path) -> None:
    (here / "out" / COMPLETE).mkdir(parents=True)
    (here / "out" / COMPLETE / "manifest.json").write_text("new")
    settle(Path("out"))
    assert [path.name for path in (here / "out").iterdir()] == ["manifest.json"]
    assert [path.name for path in here.iterdir()] == ["out"]


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
@pytest.mark.parametrize("out", ["/proc/x", "/proc/x/y"])
def test_where_no_folder_can_be_made(out: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make(here, "a")
    assert cli.main(["run", "a", "--out", out]) == 2
    said = capsys.readouterr().err
    assert said == f"gpsec: error: {out}: no results can be written there: no folder can be made in /proc\n"
