"""Runs scenarios, each in a process of its own: libsumo allows one simulation per process."""

import json
import os
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.pipes import PeerGoneError, receive, send
from gpsec.core.processes import (
    SPAWN,
    collect_garbage_rarely,
    end_with_parent,
    ended_early,
    ignore_interrupts,
    redirect_output,
    start,
)
from gpsec.core.progress import DONE, FAILED, Progress, Report
from gpsec.core.system import refusal
from gpsec.running.warmup import compile_kernels
from gpsec.scenario import ALLOW_CODE, Scenario
from gpsec.types.constants import MANIFEST

__all__ = ["Failure", "Outcome", "Progress", "run_scenarios"]

# Writes the files of one scenario into a folder that exists.
Run = Callable[[Scenario, Path, Report], None]

# Written last: a folder that has one holds a whole run.
_REPORT_EVERY_S = 0.1


@dataclass(frozen=True)
class Failure:
    """A scenario that did not finish.

    Attributes:
        scenario: its name.
        sentence: what went wrong.
        details: traceback or last output where it is a fault of gpsec, empty where the sentence says all.
        kind: of error, which has the exit status.
    """

    scenario: str
    sentence: str
    details: str = ""
    kind: type[GpsecError] = GpsecError


@dataclass
class Outcome:
    """What became of the scenarios.

    Attributes:
        finished: names, in the order in which they were given.
        failures: those that failed.
        interrupted: the user stopped the run.
    """

    finished: list[str] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    interrupted: bool = False


def run_scenarios(
    scenarios: Sequence[Scenario], work: Path, jobs: int, report: Report, run: Run | None = None
) -> Outcome:
    """Run every scenario into ``work/<name>``, at most `jobs` at a time.

    One that an earlier call has finished there, and that would come out the same, is not run again. One that fails
    does not stop the others. An interrupt (KeyboardInterrupt) stops those that run and keeps those that have finished.

    Args:
        scenarios: with names that differ.
        work: an existing folder for files in the making.
        jobs: number of processes.
        report: called in this process with what the scenarios tell.
        run: what to call in the process; the pipeline, where not given.
    """
    outcome = Outcome()
    running: dict[Connection, _Worker] = {}
    done: set[str] = set()
    try:
        waiting = [scenario for scenario in scenarios if not _found(scenario, work, done, report)]
        if run is None:
            compile_kernels(waiting, work, report)
        while waiting or running:
            while waiting and len(running) < jobs:
                scenario = waiting.pop(0)
                try:
                    worker = _start(scenario, work, run or _pipeline)
                except OSError as error:  # too many files or processes; what has finished stays
                    outcome.failures.append(_failure(scenario.name, refusal(error, "its process cannot be started")))
                    report(Progress(scenario.name, stage=FAILED))
                    continue
                running[worker.connection] = worker
            for connection in wait(list(running)) if running else ():
                worker = running[connection]  # type: ignore[index]
                if not worker.listen(report):
                    del running[worker.connection]
                    name = worker.scenario.name
                    if worker.failure is None:
                        done.add(name)
                    else:
                        outcome.failures.append(worker.failure)
                    report(Progress(name, stage=FAILED if worker.failure else DONE))
    except KeyboardInterrupt:
        outcome.interrupted = True
    finally:
        with ignore_interrupts():  # a second one must not leave processes behind
            for worker in running.values():
                worker.process.kill()  # deaf to anything gentler; its files are thrown away
            for worker in running.values():
                worker.process.join()
    outcome.finished = [scenario.name for scenario in scenarios if scenario.name in done]
    return outcome


def _found(scenario: Scenario, work: Path, done: set[str], report: Report) -> bool:
    """Note a scenario that is there already, and return whether it is."""
    if not has_result(work / scenario.name, scenario):
        return False
    done.add(scenario.name)
    report(Progress(scenario.name, stage=DONE))
    return True


def has_result(folder: Path, scenario: Scenario) -> bool:
    """Return whether `folder` holds a whole run of the scenario that would come out the same again.

    Raises:
        GpsecError: a file of the scenario is missing or wrong.
    """
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    from gpsec.outcomes.digests import are_whole
    from gpsec.pipeline.fingerprint import fingerprint

    return (
        isinstance(manifest, dict)
        and manifest.get("fingerprint") == fingerprint(scenario)
        and are_whole(folder, manifest)
    )


@dataclass
class _Worker:
    """A process and what it has said."""

    scenario: Scenario
    process: BaseProcess
    connection: Connection
    log: Path
    failure: Failure | None = None
    finished: bool = False

    def listen(self, report: Report) -> bool:
        """Take one message; return False once the process has ended.

        Raises:
            KeyboardInterrupt: the user has stopped it there, by closing its window.
        """
        try:
            message = receive(self.connection)
        except PeerGoneError:
            self._end()
            return False
        if isinstance(message, KeyboardInterrupt):
            raise message
        if isinstance(message, Progress):
            report(message)
        elif isinstance(message, Failure):
            # A fault in SUMO's process has its traceback among what that printed.
            _, fault, trace = self._last_output().rpartition("Traceback (most recent call last)")
            details = message.details or (fault + trace if issubclass(message.kind, MachineError) else "")
            self.failure = replace(message, details=details)
        else:
            self.finished = True
        return True

    def _end(self) -> None:
        self.process.join()
        if not self.finished and self.failure is None:
            said = ended_early("its process", self.process.exitcode, "a crash of gpsec or of a library")
            self.failure = Failure(self.scenario.name, said, self._last_output(), MachineError)

    def _last_output(self) -> str:
        return self.log.read_text(errors="replace")[-4000:] if self.log.is_file() else ""


def _start(scenario: Scenario, work: Path, run: Run) -> _Worker:
    # A function of the main module can only be found where that is imported too.
    context = get_context("spawn") if run.__module__ == "__main__" else SPAWN
    ours, theirs = context.Pipe(duplex=False)
    log = work / f".{scenario.name}.log"  # the dot keeps it apart from every scenario
    # Not a daemon: SUMO gets a process of its own below it, which ends when this one is gone.
    arguments = (run, scenario.model_dump_json(), work / scenario.name, log, theirs)
    process = context.Process(target=_work, args=arguments, name=scenario.name)
    start(process)
    theirs.close()
    return _Worker(scenario, process, ours, log)


def _work(run: Run, told: str, folder: Path, log: Path, connection: Connection) -> None:
    """Be the process of one scenario, which is told as JSON; `folder` has its name."""
    end_with_parent()
    collect_garbage_rarely()

    def prepared(tell: Report) -> None:
        redirect_output(log)
        scratch = folder.with_name(f".{folder.name}.tmp")
        for made in (folder, scratch):
            if made.exists():  # what is left of an earlier try
                shutil.rmtree(made)
            made.mkdir()
        # What a killed process leaves behind goes away with the folder of the run.
        tempfile.tempdir = os.environ["TMPDIR"] = str(scratch)
        # The code that it names was allowed where it comes from; it runs once its output goes to the log.
        run(Scenario.model_validate_json(told, context={ALLOW_CODE: True}), folder, tell)

    try:
        send(connection, _result(prepared, folder, _Teller(connection)))
    except PeerGoneError:
        sys.exit(1)  # the parent is gone


def _result(run: Callable[[Report], None], folder: Path, tell: Report) -> object:
    """Run the scenario that `folder` has the name of; return what to tell the parent: True, a failure or an interrupt.

    Raises:
        PeerGoneError: there is no parent any more.
    """
    try:
        run(tell)
    except GpsecError as error:
        return _failure(folder.name, error)
    except KeyboardInterrupt as interrupt:
        return interrupt
    except PeerGoneError:
        raise
    except OSError as error:
        said = refusal(error, f"{error.filename or folder}: cannot be used")
        return _failure(folder.name, said) if isinstance(said, MachineError) else _fault(folder.name, error)
    except Exception as error:
        return _fault(folder.name, error)
    return True


def _failure(name: str, error: GpsecError) -> Failure:
    return Failure(name, str(error), kind=type(error))


def _fault(name: str, error: Exception) -> Failure:
    said = f"fault in gpsec ({type(error).__name__}: {error})"
    return Failure(name, said, "".join(traceback.format_exception(error)), MachineError)


class _Teller:
    """Sends progress to the parent, not more often than a reader can see."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._last_s = -1.0
        self._stage = ""

    def __call__(self, progress: Progress) -> None:
        now_s = time.monotonic()
        if progress.note or progress.stage != self._stage or now_s - self._last_s >= _REPORT_EVERY_S:
            send(self._connection, progress)
            self._last_s, self._stage = now_s, progress.stage


def _pipeline(scenario: Scenario, folder: Path, report: Report) -> None:
    from gpsec.pipeline.run import run_scenario

    run_scenario(scenario, folder, report)
