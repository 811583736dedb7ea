"""What killed runs leave is listed, said at the next start and removed; what somebody else made never is."""

import os
import tempfile
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.console import clean
from gpsec.core.errors import GpsecError
from gpsec.running import batch
from gpsec.running.leftovers import leftovers
from gpsec.running.publishing import COMPLETE
from gpsec.running.workers import Outcome
from gpsec.running.workshop import workshop, workshop_of

FORMER_KERNELS = "0123456789abcdef"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("cache", "temporary", "results"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    return tmp_path


def killed(out: Path, *scenarios: str) -> Path:
    """Leave what a run into `out` leaves that is killed."""
    folder = workshop_of(out)
    folder.mkdir()
    (folder / ".lock").touch()
    for name in scenarios:
        (folder / name).mkdir()
        (folder / name / "events.csv").write_text("x" * 1_500_000)
    return folder


def long_ago(path: Path) -> Path:
    os.utime(path, (0, 0))
    return path


def long_ago_with(path: Path, size: int) -> Path:
    path.mkdir()
    (path / "file").write_text("x" * size)
    return long_ago(path)


def litter(here: Path) -> list[Path]:
    """Leave one of each kind."""
    made = [
        killed(here / "results" / "town", "town"),
        here / "results" / ".town.partial-ab_d3f9h",
        here / ".gpsec-demand-abcdefgh",
        here / ".gpsec-import-abcdefgh",
        here / "temporary" / "gpsec-sumo-abcdefgh",
        here / "cache" / "kernels" / FORMER_KERNELS,
    ]
    for path in made[1:]:
        path.mkdir(parents=True)
        (path / "file").touch()
        long_ago(path)
    return made


def others(here: Path) -> list[Path]:
    """Make what looks like it, and is somebody else's or in use."""
    made = [
        here / ".rsync.partial",  # no lock of ours
        here / "results" / "town",
        here / ".mine.partial-0123456789",
        here / "temporary" / "gpsec-sumo-now_here",  # young
        here / "temporary" / "other-abcdefgh",
        here / "cache" / "notes",
    ]
    for path in made:
        path.mkdir()
    (here / ".file.partial").touch()
    (here / ".link.partial").symlink_to(here / "results" / ".town.partial")
    return [*made, here / ".file.partial", here / ".link.partial"]


def test_all_of_it_is_listed_and_removed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    litter_, others_ = litter(here), others(here)
    with workshop(here / "results" / "busy"):
        assert cli.main(["clean"]) == 0
        listed = capsys.readouterr().out.splitlines()
        assert listed[-1] == "nothing has been removed; --yes does it"
        paths = [line.partition(": ")[0] for line in listed[:-1]]
        assert {Path(path).resolve() for path in paths} == set(litter_)
        assert len(paths) == len(litter_)
        assert any("town.partial: 1.5 MB, of a run that stopped" in line for line in listed)
        assert all(path.exists() for path in litter_)
        assert cli.main(["clean", "--yes"]) == 0
        assert capsys.readouterr().out.splitlines()[-1] == f"removed {len(litter_)} of them"
        assert workshop_of(here / "results" / "busy").is_dir()
    assert not any(path.exists() for path in litter_)
    assert all(os.path.lexists(path) for path in others_)
    assert cli.main(["clean", "--yes"]) == 0
    assert capsys.readouterr().out == "nothing is left behind\n"


def test_what_is_small_is_not_said_to_be_nothing(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = long_ago_with(here / ".gpsec-demand-abcdefgh", 1_200)
    size = 1_200 + folder.lstat().st_size
    assert cli.main(["clean"]) == 0
    assert f": {size / 1000:.1f} kB, of a command that was killed" in capsys.readouterr().out


@pytest.mark.parametrize(("answer", "removed"), [("y", True), ("", False), ("n", False)])
def test_the_user_is_asked(here: Path, monkeypatch: pytest.MonkeyPatch, answer: str, removed: bool) -> None:
    left = killed(here / "results" / "town", "town")
    asked: list[str] = []

    def answered(question: str) -> str:
        asked.append(question)
        return answer

    monkeypatch.setattr(clean.sys.stdin, "isatty", lambda: True)
    monkeypatch.setattr("builtins.input", answered)
    assert cli.main(["clean"]) == 0
    assert asked == ["remove 1 of them, 1.5 MB? [y/N] "]
    assert left.exists() is not removed


def test_a_run_that_has_begun_meanwhile_is_left_alone(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    killed(here / "results" / "town", "town")
    (left,) = leftovers(here / "results")
    with workshop(here / "results" / "town"):
        with pytest.raises(GpsecError, match="another run is being written there"):
            left.remove()
        assert (left.path / "town" / "events.csv").exists()


def test_a_folder_that_is_not_there(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["clean", "nowhere"]) == 2
    assert "nowhere: cannot be read: No such file or directory" in capsys.readouterr().err


@pytest.mark.parametrize("resume", [False, True])
def test_a_start_says_what_it_found(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], resume: bool
) -> None:
    (here / "town").mkdir()
    (here / "town" / "town.sumocfg").touch()
    killed(here / "results" / "town", "town")
    killed(here / "results" / "other", "other")
    (here / "results" / "town" / COMPLETE).mkdir(parents=True)
    monkeypatch.setattr(batch, "_missing", lambda groups: groups)
    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: Outcome())
    assert cli.main(["run", "town", *(["--resume"] if resume else [])]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    results = here / "results"
    becomes = "to go on with" if resume else "thrown away (--resume would have gone on)"
    assert line == (
        f"gpsec: found {results}/town half replaced, which is whole now; "
        f"town in {results}/.town.partial, {becomes}; "
        f"{results}/.other.partial and 0 more of other runs (gpsec clean)"
    )


def test_a_start_with_nothing_left_says_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "town").mkdir()
    (here / "town" / "town.sumocfg").touch()
    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: Outcome())
    assert cli.main(["run", "town"]) == 0
    assert capsys.readouterr().err == ""
