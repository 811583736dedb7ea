"""What is left where the user or the terminal ends a run."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from select import select

import pytest

from .runs import make

REPOSITORY = Path(__file__).parents[2]


INTERRUPTED = """
import sys, time
from pathlib import Path
sys.path.insert(0, {repository!r})
from tests.batches import main_with
from tests.cli.runs import write_results

def run(scenario, folder, report):
    if scenario.name == "slow":
        (folder / "detection.csv").write_text("half")
        Path("slow-began").touch()
        time.sleep(60)
    write_results(scenario, folder)

if __name__ == "__main__":
    sys.exit(main_with(run, ["run", "fast", "slow", "--out", "all", "--jobs", "1"]))
"""


def test_an_interrupt_keeps_what_has_finished(here: Path) -> None:
    make(here, "fast")
    make(here, "slow")
    (here / "script.py").write_text(textwrap.dedent(INTERRUPTED).format(repository=str(REPOSITORY)))
    command = [sys.executable, "script.py"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True)
    try:
        deadline = time.monotonic() + 60.0
        while not (here / "slow-began").exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)  # as the terminal does: to every process
        _, err = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130, err.decode()
    assert b"Traceback" not in err
    assert b"interrupted; fast kept in" in err
    assert b"--resume goes on" in err
    assert (here / "all" / "events.csv").read_text() == "scenario,seed\nfast,1\n"
    manifest = json.loads((here / "all" / "manifest.json").read_text())
    assert manifest["unfinished"] == [{"scenario": "slow", "reason": "interrupted"}]
    assert sorted(path.name for path in here.iterdir()) == [
        *(".all.partial", "all", "fast", "script.py", "slow", "slow-began")
    ]


HUNG_UP = """
import os, sys
sys.path.insert(0, {repository!r})
from tests.batches import main_with
from tests.cli.runs import write_results

def run(scenario, folder, report):
    with open("began", "w") as began:
        began.write("!")
    with open("go-on") as go_on:
        go_on.read(1)
    write_results(scenario, folder)

if __name__ == "__main__":
    sys.exit(main_with(run, ["run", "town", "--out", "all"]))
"""


@pytest.mark.parametrize(("handler", "status"), [(signal.SIG_IGN, 0), (signal.SIG_DFL, 130)], ids=["nohup", "without"])
def test_with_nohup_a_run_goes_on_when_the_terminal_hangs_up(here: Path, handler: signal.Handlers, status: int) -> None:
    make(here, "town")
    (here / "script.py").write_text(textwrap.dedent(HUNG_UP).format(repository=str(REPOSITORY)))
    pipes = {}
    for name in ("began", "go-on"):
        os.mkfifo(name)
        pipes[name] = os.open(name, os.O_RDWR)
    process = subprocess.Popen(
        [sys.executable, "script.py"],
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, handler),
    )
    try:
        ready, _, _ = select([pipes["began"]], [], [], 60.0)
        assert ready
        os.killpg(process.pid, signal.SIGHUP)  # as the terminal does: to every process
        if handler == signal.SIG_IGN:
            os.write(pipes["go-on"], b"!")
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
        for pipe in pipes.values():
            os.close(pipe)
    assert process.returncode == status, err.decode()
    assert b"Traceback" not in err
    assert (here / "all" / "manifest.json").exists() is (status == 0)
