"""The executor of all that is run many times: tasks in processes of their own, so many at a time.

Seeds, closed-loop worlds, the paper's runs, stress and sweeps all come here. libsumo allows one simulation per process.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Protocol

from gpsec.core.processes import ignore_interrupts
from gpsec.core.progress import DONE, FAILED, Progress, Report
from gpsec.core.system import refusal
from gpsec.running.task_process import Failure, Run, Task, TaskProcess, pipeline
from gpsec.running.warmup import compile_kernels
from gpsec.scenario import Scenario
from gpsec.types.constants import MANIFEST

__all__ = ["Desk", "Failure", "Outcome", "Progress", "Run", "Task", "run_scenarios", "run_tasks"]

# A desk is told that all is well at least so often.
_BEAT_S = 2.0


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


class Desk(Protocol):
    """Where tasks come from, and what becomes of them."""

    def take(self) -> Task | None:
        """Return the next task, None where there is none for now."""
        ...

    def beat(self) -> None:
        """Be told that those which were taken are still at work; called every two seconds or more often."""
        ...

    def settle(self, task: Task, failure: Failure | None) -> Failure | None:
        """Take what has become of a task; return why it does not count, None where it has finished."""
        ...

    def drop(self, task: Task) -> None:
        """Take back a task that was stopped."""
        ...


def run_tasks(desk: Desk, jobs: int, report: Report, run: Run = pipeline) -> bool:
    """Run what a desk gives, at most `jobs` tasks at a time, until it has none; return whether the user stopped it.

    One that fails does not stop the others. An interrupt (KeyboardInterrupt) stops those that run.

    Args:
        desk: gives tasks and takes what becomes of them.
        jobs: number of processes.
        report: called in this process with what the tasks tell, under their names.
        run: what to call in the process.
    """
    running: dict[Connection, TaskProcess] = {}
    try:
        while True:
            while len(running) < jobs and (task := desk.take()) is not None:
                try:
                    made = TaskProcess(task, run)
                except OSError as error:  # too many files or processes; what has finished stays
                    refused = refusal(error, "its process cannot be started")
                    _settle(desk, task, Failure.of(task.name, refused), report)
                    continue
                running[made.connection] = made
            if not running:
                return False
            for connection in wait(list(running), timeout=_BEAT_S):
                one = running[connection]  # type: ignore[index]
                if not one.listen(report):
                    del running[one.connection]
                    _settle(desk, one.task, one.failure, report)
            desk.beat()
    except KeyboardInterrupt:
        return True
    finally:
        with ignore_interrupts():  # a second one must not leave processes behind
            for one in running.values():
                one.process.kill()  # deaf to anything gentler; its files are thrown away
            for one in running.values():
                one.process.join()
                desk.drop(one.task)


def _settle(desk: Desk, task: Task, failure: Failure | None, report: Report) -> None:
    failure = desk.settle(task, failure)
    report(Progress(task.name, stage=FAILED if failure else DONE))


class _List:
    """A desk with the scenarios of one call."""

    def __init__(self, scenarios: Sequence[Scenario], work: Path, outcome: Outcome, done: set[str]) -> None:
        self._waiting = list(scenarios)
        self._work = work
        self._outcome = outcome
        self._done = done

    def take(self) -> Task | None:
        if not self._waiting:
            return None
        one, work = self._waiting.pop(0), self._work
        # The dot keeps the log apart from every scenario.
        return Task(one.name, one.model_dump_json(), work / one.name, work / f".{one.name}.log")

    def beat(self) -> None:
        return

    def settle(self, task: Task, failure: Failure | None) -> Failure | None:
        if failure is None:
            self._done.add(task.name)
        else:
            self._outcome.failures.append(failure)
        return failure

    def drop(self, task: Task) -> None:
        return


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
    outcome, done = Outcome(), set[str]()
    try:
        waiting = [scenario for scenario in scenarios if not _found(scenario, work, done, report)]
        if run is None:
            compile_kernels(waiting, work, report)
        outcome.interrupted = run_tasks(_List(waiting, work, outcome, done), jobs, report, run or pipeline)
    except KeyboardInterrupt:
        outcome.interrupted = True
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
