"""One task: a scenario in a process of its own, what it tells meanwhile, and how it ended."""

import os
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from pydantic import ValidationError

from gpsec.core.errors import GpsecError, MachineError, shown
from gpsec.core.pipes import PeerGoneError, receive, send
from gpsec.core.processes import (
    SPAWN,
    collect_garbage_rarely,
    end_with_parent,
    ended_early,
    redirect_output,
    start,
)
from gpsec.core.progress import Progress, Report
from gpsec.core.system import refusal
from gpsec.scenario import ALLOW_CODE, Scenario

# Writes the files of one scenario into a folder that exists.
Run = Callable[[Scenario, Path, Report], None]

_REPORT_EVERY_S = 0.1


class UnfitError(MachineError):
    """Here is not what a task was made with: another version, another file, a part that is missing."""


@dataclass(frozen=True)
class Task:
    """A scenario that is to be run.

    Attributes:
        name: in the progress, and in what is said of it.
        told: the scenario as JSON.
        folder: of its files, in a folder that exists; what an earlier try has left there is thrown away.
        log: file that takes what SUMO and libraries print.
        allow_code: the code that the scenario names may be run.
    """

    name: str
    told: str
    folder: Path
    log: Path
    allow_code: bool = True


@dataclass(frozen=True)
class Failure:
    """A task that did not finish.

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

    @classmethod
    def of(cls, name: str, error: GpsecError) -> "Failure":
        """Return the failure that an error of one sentence is."""
        return cls(name, str(error), kind=type(error))


class TaskProcess:
    """The process of a task.

    Attributes:
        task: that it was started with.
        process: it.
        connection: of what it says.
        failure: what it says, or how it ended, where it did not finish.
    """

    def __init__(self, task: Task, run: Run) -> None:
        """Start it.

        Raises:
            OSError: there are too many files or processes.
        """
        # A function of the main module can only be found where that is imported too.
        context = get_context("spawn") if run.__module__ == "__main__" else SPAWN
        ours, theirs = context.Pipe(duplex=False)
        # Not a daemon: SUMO gets a process of its own below it, which ends when this one is gone.
        process: BaseProcess = context.Process(target=_work, args=(run, task, theirs), name=task.name)
        start(process)
        theirs.close()
        self.task = task
        self.process = process
        self.connection: Connection = ours
        self.failure: Failure | None = None
        self._finished = False

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
            report(replace(message, scenario=self.task.name))
        elif isinstance(message, Failure):
            # A fault in SUMO's process has its traceback among what that printed.
            _, fault, trace = self._last_output().rpartition("Traceback (most recent call last)")
            details = message.details or (fault + trace if issubclass(message.kind, MachineError) else "")
            self.failure = replace(message, details=details)
        else:
            self._finished = True
        return True

    def _end(self) -> None:
        self.process.join()
        if not self._finished and self.failure is None:
            said = ended_early("its process", self.process.exitcode, "a crash of gpsec or of a library")
            self.failure = Failure(self.task.name, said, self._last_output(), MachineError)

    def _last_output(self) -> str:
        return self.task.log.read_text(errors="replace")[-4000:] if self.task.log.is_file() else ""


def _work(run: Run, task: Task, connection: Connection) -> None:
    """Be the process of a task."""
    end_with_parent()
    collect_garbage_rarely()
    folder = task.folder

    def prepared(tell: Report) -> None:
        redirect_output(task.log)
        scratch = folder.with_name(f".{folder.name}.tmp")
        for made in (folder, scratch):
            if made.exists():  # what is left of an earlier try
                shutil.rmtree(made)
            made.mkdir()
        # What a killed process leaves behind goes away with the folder of the run.
        tempfile.tempdir = os.environ["TMPDIR"] = str(scratch)
        run(_scenario(task), folder, tell)

    try:
        send(connection, _result(prepared, task, _Teller(connection)))
    except PeerGoneError:
        sys.exit(1)  # the parent is gone


def _scenario(task: Task) -> Scenario:
    """Return the scenario of a task.

    Raises:
        UnfitError: it has been read where it was made, and cannot be here.
    """
    try:
        return Scenario.model_validate_json(task.told, context={ALLOW_CODE: task.allow_code})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key, said = ".".join(map(str, first["loc"])), first["msg"].removeprefix("Value error, ")
        raise UnfitError(f"{shown(key)}: cannot be used on this machine: {said}") from None


def _result(run: Callable[[Report], None], task: Task, tell: Report) -> object:
    """Run a task; return what to tell the parent: True, a failure or an interrupt.

    Raises:
        PeerGoneError: there is no parent any more.
    """
    try:
        run(tell)
    except GpsecError as error:
        return Failure.of(task.name, error)
    except KeyboardInterrupt as interrupt:
        return interrupt
    except PeerGoneError:
        raise
    except OSError as error:
        said = refusal(error, f"{error.filename or task.folder}: cannot be used")
        return Failure.of(task.name, said) if isinstance(said, MachineError) else _fault(task.name, error)
    except Exception as error:
        return _fault(task.name, error)
    return True


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


def pipeline(scenario: Scenario, folder: Path, report: Report) -> None:
    """Run a scenario, as `gpsec.pipeline.run.run_scenario` does, which is imported in the process that needs it."""
    from gpsec.pipeline.run import run_scenario

    run_scenario(scenario, folder, report)
