"""The real command, in a process of its own: SUMO's refusals, crashes, signals, places that cannot be written."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from .worlds import CAR, FLOW, Case, config, lay_out, routes

GPSEC = [sys.executable, "-m", "gpsec"]
# SUMO reads vehicles as they depart, and gives up at the last one while the evaluation is some steps behind.
LATE = "".join(
    f'<vehicle id="v{at}" type="{"car" if at < 30 else "nope"}" depart="{0.2 * at:.1f}"><route edges="A0A1 A1A2"/>'
    "</vehicle>"
    for at in range(31)
)
DISCONNECTED = '<vehicle id="t" type="car" depart="5"><route edges="A0A1 B2C2"/></vehicle>'
NOBODY = '<vType id="car"><param key="gpsec.equipped" value="0"/></vType>'


def gpsec(*arguments: str, **environment: str) -> tuple[int, list[str]]:
    """Run the command; return its exit status and the lines that say what is wrong."""
    done = subprocess.run(
        [*GPSEC, *arguments], capture_output=True, text=True, env={**os.environ, **environment}, timeout=120
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done.returncode, [line for line in done.stderr.splitlines() if line.startswith("gpsec: error: ")]


def members(group: int) -> list[str]:
    """Return the processes of a process group that are alive."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, of = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(of) == group and state != "Z":
            found.append(stat.parent.name)
    return found


def gone(group: int, within_s: float = 10.0) -> bool:
    deadline = time.monotonic() + within_s
    while members(group) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not members(group)


def heed_hangups() -> None:
    """Let a command under test die of a hangup, also where the tests, started with nohup, do not."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def test_runs_that_cannot_be(here: Path, grid: str) -> None:
    """Each of them is one sentence, and none leaves anything behind."""
    wrong = {
        "refused": Case(
            ("run.sumocfg: SUMO says: ", "'t'", "'A0A1'"), {"cars.rou.xml": routes(CAR + FLOW + DISCONNECTED)}
        ),
        "nobody": Case(
            ("run.sumocfg: no vehicle is equipped", "gpsec.equipped"), {"cars.rou.xml": routes(NOBODY + FLOW)}
        ),
        "unknown": Case(("run.sumocfg: SUMO says: ", "'nope'", "'v30'"), {"cars.rou.xml": routes(CAR + LATE)}),
        "late": Case(("run.sumocfg: no vehicle departs",), {"run.sumocfg": config('<begin value="1000"/>')}),
    }
    for name, case in wrong.items():
        lay_out(here, grid, case)
        (here / "s").rename(here / name)
    status, said = gpsec("run", *wrong, "--duration", "8", "--jobs", "2")
    assert status == 2
    assert len(said) == len(wrong)
    for name, case in wrong.items():
        (line,) = (line for line in said if f"scenario '{name}'" in line)
        assert all(fragment in line for fragment in case.says), line
    assert sorted(path.name for path in here.iterdir()) == sorted(wrong)


def test_crash_of_sumo_is_a_sentence(here: Path, grid: str) -> None:
    # SUMO 1.28 ends with a segmentation fault on a net whose junctions have lanes but no connections.
    lay_out(here, grid, Case((), net=lambda net: re.sub(r"<connection [^>]*/>", "", net)))
    status, said = gpsec("check", "s")
    assert status == 1
    assert len(said) == 1
    assert said[0].endswith("s/run.sumocfg: the process of SUMO ended early (SIGSEGV: a crash of SUMO itself)")


@pytest.mark.parametrize("place", ["file", "below a file"])
def test_cache_that_is_no_folder(here: Path, grid: str, place: str) -> None:
    lay_out(here, grid, Case(()))
    (here / "cache").touch()
    cache = here / "cache" if place == "file" else here / "cache" / "below"
    status, said = gpsec("run", "s", GPSEC_CACHE=str(cache))
    assert status == 2
    assert said == [f"gpsec: error: GPSEC_CACHE={cache}: expected a folder that can be written; "
                    "name another one in GPSEC_CACHE"]  # fmt: skip
    assert sorted(path.name for path in here.iterdir()) == ["cache", "s"]


@pytest.mark.parametrize("variable", ["GPSEC_CACHE", "NUMBA_CACHE_DIR"])
def test_cache_that_others_can_write(here: Path, grid: str, variable: str) -> None:
    lay_out(here, grid, Case(()))
    (here / "cache").mkdir()
    (here / "cache").chmod(0o777)
    status, said = gpsec("run", "s", **{"GPSEC_CACHE": str(here / "own"), variable: str(here / "cache")})
    assert status == 2
    (line,) = said
    assert line.startswith(f"gpsec: error: {variable}={here / 'cache'}: expected a folder that only you and root can ")
    assert line.endswith(f"(chown, chmod go-w) or name another one in {variable}")
    assert f"others can write {here / 'cache'} (mode 777)" in line


@pytest.mark.parametrize("arguments", [("list", "attacks"), ("--help",)])
def test_reader_that_has_had_enough(arguments: tuple[str, ...]) -> None:
    process = subprocess.Popen([*GPSEC, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == b""
    process.wait(30)


@pytest.mark.parametrize(
    ("number", "stage"),
    [
        (signal.SIGTERM, "loading"),
        (signal.SIGINT, "running"),
        (signal.SIGHUP, "running"),
        (signal.SIGKILL, "running"),
    ],
)
def test_signals_leave_nothing_behind(here: Path, grid: str, number: int, stage: str) -> None:
    """To the command alone, or to the whole group as a terminal does it; SIGKILL goes to a worker."""
    flow = FLOW.replace('end="20"', 'end="100000"')
    lay_out(here, grid, Case((), {"cars.rou.xml": routes(CAR + flow)}))
    process = subprocess.Popen(
        [*GPSEC, "run", "s", "--duration", "90000"],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=heed_hangups,
    )
    assert process.stderr is not None
    try:
        said = ""
        while stage and stage not in said:
            line = process.stderr.readline()
            assert line, said
            said += line
        time.sleep(0.6)
        if number == signal.SIGKILL:
            others = [int(pid) for pid in members(process.pid) if int(pid) != process.pid]
            os.kill(max(others), signal.SIGKILL)
        elif number == signal.SIGINT:
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
        _, rest = process.communicate(timeout=30)
        assert gone(process.pid)
    finally:
        if members(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == (130 if number != signal.SIGKILL else process.returncode), rest
    assert process.returncode in (1, 2, 130)
    assert "Traceback" not in rest
    assert [path.name for path in here.iterdir()] == ["s"]
