"""A run without a simulation, for tests of what runs many; its bytes depend on the scenario alone."""

import json
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

from gpsec.core.errors import GpsecError
from gpsec.core.progress import Progress, Report
from gpsec.outcomes.digests import table_digests
from gpsec.outcomes.tables import TABLES
from gpsec.scenario import Scenario

PLAN = """
[[entries]]
name = "first"
scenarios = ["{scenario}"]
seeds = "{seeds}"
"""
SCENARIO = Path(__file__).parents[2] / "scenarios" / "slow_curve"


def fake_run(scenario: Scenario, folder: Path, report: Report) -> None:
    report(Progress(scenario.name, 1.0, 2.0))
    if scenario.seed == 13:
        raise GpsecError("thirteen.net.xml: expected lanes, found none")
    for name in TABLES:
        (folder / f"{name}.csv").write_text("seed\n" + f"{scenario.seed:07}\n" * 10_000)
        time.sleep(0.005)
    stated = {"scenario": scenario.name, "fingerprint": folder.name, "tables": table_digests(folder)}
    (folder / "manifest.json").write_text(json.dumps(stated))


def slow_run(scenario: Scenario, folder: Path, report: Report) -> None:
    """Take half a second, so that there is time to be killed; leave a trace of who ran it."""
    began = folder.parents[4] / "began"
    began.mkdir(exist_ok=True)
    (began / f"{scenario.seed}-{os.getpid()}").touch()
    time.sleep(0.5)
    fake_run(scenario, folder, report)


def plan_of(folder: Path, seeds: str) -> Path:
    path = folder / "plan.toml"
    path.write_text(PLAN.format(scenario=SCENARIO, seeds=seeds))
    return path


def content(store: Path) -> dict[str, bytes]:
    """Return all files of the runs in a store."""
    return {
        path.relative_to(store).as_posix(): path.read_bytes()
        for folder in store.iterdir()
        if folder.is_dir() and not folder.name.startswith(".")
        for path in folder.iterdir()
    }


def nothing_left(store: Path) -> bool:
    return not list((store / ".claims").iterdir()) and not list((store / ".work").iterdir())


def parent_of(process: int) -> int:
    """Return the process that has started another one."""
    return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])


def kill_when(found: Callable[[], list[int]]) -> threading.Thread:
    """Kill whoever has started the first of some processes, as soon as there are any."""

    def wait() -> None:
        until = time.monotonic() + 300.0
        while not (processes := found()):
            assert time.monotonic() < until
            time.sleep(0.01)
        os.kill(parent_of(processes[0]), signal.SIGKILL)

    thread = threading.Thread(target=wait)
    thread.start()
    return thread
