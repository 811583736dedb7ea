"""What the system refuses is one sentence with the exit status for it, and what is whole stays."""

import ctypes
import errno
import json
import os
import resource
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.console import aftermath
from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.system import in_a_sentence, refusal
from gpsec.running import batch, impact

MEBIBYTE = 1 << 20
SLOW_CURVE = Path(__file__).parents[1] / "scenarios" / "slow_curve"

# Each scenario has tables of 600 kB; only "small" has less.
SCRIPT = """
import sys
from pathlib import Path
sys.path.insert(0, {repository!r})
from gpsec.outcomes.digests import table_digests
from gpsec.pipeline.fingerprint import fingerprint
from tests.batches import main_with
from tests.cli.runs import write_results
import json

def run(scenario, folder, report):
    Path("began-" + scenario.name).touch()
    write_results(scenario, folder)
    rows = 100 if scenario.name == "small" else 60000
    (folder / "events.csv").write_text("scenario,seed\\n" + (scenario.name[:1] + ",1234567\\n") * rows)
    stated = {{"scenario": scenario.name, "fingerprint": fingerprint(scenario), "tables": table_digests(folder)}}
    (folder / "manifest.json").write_text(json.dumps(stated))

if __name__ == "__main__":
    sys.exit(main_with(run, ["run", *sys.argv[1:], "--out", "all", "--no-report", "--jobs", "1"]))
"""


@pytest.mark.parametrize(
    ("number", "kind", "said"),
    [
        (errno.ENOSPC, MachineError, "it: No space left on device"),
        (errno.EFBIG, MachineError, "it: File too large (ulimit -f)"),
        (errno.EMFILE, MachineError, "it: Too many open files (ulimit -n)"),
        (errno.EIO, MachineError, "it: Input/output error"),
        (errno.ENOENT, GpsecError, "it: No such file or directory"),
        (errno.EACCES, GpsecError, "it: Permission denied"),
        (errno.EROFS, GpsecError, "it: Read-only file system"),
    ],
)
def test_whose_fault_it_is(number: int, kind: type[GpsecError], said: str) -> None:
    error = refusal(OSError(number, os.strerror(number)), "it")
    assert (type(error), str(error)) == (kind, said)


def test_an_error_without_a_number() -> None:
    """As numpy raises it, where less was written than there is."""
    with pytest.raises(MachineError, match=r"^it: 10 requested and 3 written$"), in_a_sentence("it"):
        raise OSError("10 requested and 3 written")


def test_a_reader_who_has_had_enough_is_no_refusal() -> None:
    with pytest.raises(BrokenPipeError), in_a_sentence("it"):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    lay_out(tmp_path)
    return tmp_path


def lay_out(here: Path) -> None:
    for name in ("small", "one", "two"):
        (here / name).mkdir()
        (here / name / "gpsec.toml").write_text(f'sumocfg = "{SLOW_CURVE}/slow_curve.sumocfg"\n')
    (here / "script.py").write_text(textwrap.dedent(SCRIPT).format(repository=str(Path(__file__).parents[1])))


def run(here: Path, *arguments: str, largest: int = -1) -> tuple[int, str]:
    """Run the script, which may write no file of more than `largest` bytes; return exit status and messages."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    done = subprocess.run(
        [sys.executable, "script.py", *arguments],
        cwd=here,
        capture_output=True,
        text=True,
        preexec_fn=limited,
        timeout=120,
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done.returncode, done.stderr


def errors(said: str) -> list[str]:
    return [line for line in said.splitlines() if line.startswith("gpsec: error: ")]


def test_a_table_that_cannot_be_written(here: Path) -> None:
    status, said = run(here, "one", "small", largest=MEBIBYTE // 4)
    assert status == 1
    assert len(errors(said)) == 1, said
    (line,) = errors(said)
    assert line.startswith("gpsec: error: scenario 'one': ")
    assert line.endswith("File too large (ulimit -f)")
    assert (here / "all" / "events.csv").read_text().startswith("scenario,seed\ns,")
    assert json.loads((here / "all" / "manifest.json").read_text())["unfinished"][0]["scenario"] == "one"


def test_tables_that_cannot_be_joined(here: Path) -> None:
    """What has finished is whole, and the next start goes on with it."""
    status, said = run(here, "one", "two", largest=MEBIBYTE)
    assert status == 1
    assert len(errors(said)) == 1, said
    (line,) = errors(said)
    assert line.endswith("/all: cannot be written: File too large (ulimit -f)")
    assert "--resume goes on" in said
    assert not (here / "all").exists()
    for name in ("one", "two"):
        (here / f"began-{name}").unlink()
    status, said = run(here, "one", "two", "--resume")
    assert (status, errors(said)) == (0, [])
    assert not list(here.glob("began-*"))
    assert len((here / "all" / "events.csv").read_text().splitlines()) == 120001


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Give a file system of a mebibyte and a half."""
    libc = ctypes.CDLL(None, use_errno=True)
    disk = tmp_path / "disk"
    disk.mkdir()
    if libc.mount(b"tmpfs", os.fsencode(disk), b"tmpfs", 0, b"size=1536k") != 0:
        pytest.skip("only an administrator may mount a file system")
    yield disk
    assert libc.umount(os.fsencode(disk)) == 0


def test_a_full_disk(small_disk: Path) -> None:
    lay_out(small_disk)
    assert run(small_disk, "small")[0] == 0
    before = (small_disk / "all" / "events.csv").read_text()
    # Two tables of 600 kB have room, not so what they are joined to.
    status, said = run(small_disk, "one", "two", "--overwrite")
    assert status == 1
    assert len(errors(said)) == 1, said
    (line,) = errors(said)
    assert "No space left on device" in line
    assert (small_disk / "all" / "events.csv").read_text() == before


def fails(number: int) -> Callable[..., object]:
    def failing(*arguments: object, **options: object) -> object:
        raise OSError(number, os.strerror(number))

    return failing


def test_a_report_that_cannot_be_written(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from gpsec.running.workers import Outcome

    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: Outcome(["one", "two"]))
    monkeypatch.setattr(batch.Batch, "_publish", lambda self, folder, *others: folder.mkdir())
    monkeypatch.setattr(aftermath, "show_findings", lambda folder, all_: print(f"tables of {folder.name}"))
    monkeypatch.setattr(impact, "write_impact", lambda folder: None)
    monkeypatch.setattr("gpsec.running.results.load", lambda folder: None)
    monkeypatch.setattr("gpsec.report.make.write_report", fails(errno.ENOSPC))
    assert cli.main(["run", "one", "two"]) == 1
    captured = capsys.readouterr()
    assert captured.out == "tables of one\ntables of two\n"
    assert [line.rpartition("/")[2] for line in errors(captured.err)] == [
        f"{name}: no report can be written there: No space left on device" for name in ("one", "two")
    ]


def test_a_process_that_cannot_be_started(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("gpsec.running.workers.compile_kernels", lambda *arguments: None)
    monkeypatch.setattr("gpsec.running.workers.TaskProcess", fails(errno.EAGAIN))
    assert cli.main(["run", "one"]) == 1
    (line,) = errors(capsys.readouterr().err)
    assert line.startswith("gpsec: error: scenario 'one': its process cannot be started: Resource temporarily")


@pytest.mark.parametrize("arguments", [("list", "attacks"), ("schema",), ("--help",), ("--version",)])
def test_an_output_that_is_full(arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "gpsec", *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    assert done.returncode == 1
    assert done.stderr.startswith("gpsec: error: ")
    assert done.stderr.endswith(": No space left on device\n")
    assert done.stderr.count("\n") == 1


def test_without_any_output() -> None:
    command = f"exec {sys.executable} -m gpsec list attacks >&- 2>&-"
    assert subprocess.run(command, shell=True, timeout=60).returncode == 0


def test_few_files_at_once(here: Path) -> None:
    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (20, 20))

    done = subprocess.run(
        [sys.executable, "-m", "gpsec", "run", str(SLOW_CURVE), "--duration", "1", "--engine", "reference"],
        cwd=here,
        capture_output=True,
        text=True,
        preexec_fn=limited,
        timeout=120,
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stderr, done.stderr
    (line,) = errors(done.stderr)
    assert line.endswith("Too many open files (ulimit -n)")
    assert not (here / "results").exists()
