"""`gpsec run`: from scenario arguments to published folders and tables on the terminal."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from threading import Thread

from rich.console import Console

from gpsec.console import terminal
from gpsec.console.bars import display
from gpsec.console.complaint import complain
from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.system import in_a_sentence
from gpsec.core.threads import cores
from gpsec.running.batch import Batch, claimed
from gpsec.running.folders import resolved
from gpsec.running.workers import Failure, Outcome, Run
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.outside import NOTHING, Outside
from gpsec.scenario.overrides import Override

INTERRUPTED = 130


@dataclass(frozen=True)
class Output:
    """What a run leaves, and where.

    Attributes:
        out: one folder for all scenarios; None gives each its ``results/<name>``.
        overwrite: replace the run that a folder holds.
        resume: go on with what a run that stopped has left.
        report: write ``report.html`` into each folder.
        parquet: write the large tables as Parquet files too.
    """

    out: Path | None = None
    overwrite: bool = False
    resume: bool = False
    report: bool = True
    parquet: bool = False

    def groups(self, scenarios: Sequence[Scenario]) -> dict[Path, list[Scenario]]:
        """Return the scenarios of each folder."""
        if self.out is not None:
            return {resolved(self.out): list(scenarios)}
        return {resolved(Path("results") / scenario.name): [scenario] for scenario in scenarios}


def launch(
    arguments: Sequence[str],
    overrides: Sequence[Override],
    output: Output,
    jobs: int | None = None,
    run: Run | None = None,
    *,
    outside: Outside = NOTHING,
) -> int:
    """Run the scenarios, at most `jobs` at a time, and return the exit status.

    What has finished is kept when another one fails or the user interrupts. `run` takes the place of the pipeline, as
    in `gpsec.running.workers.run_scenarios`.

    Raises:
        GpsecError: a scenario or a folder is not as it should be; nothing has been run then.
    """
    scenarios = [load_scenario(argument, overrides, outside) for argument in arguments]
    _check_names(scenarios, arguments)
    messages = terminal.messages()
    with claimed(output.groups(scenarios), overwrite=output.overwrite, resume=output.resume) as batch:
        if batch.found:
            messages.print(f"gpsec: found {batch.found}", markup=False, highlight=False, soft_wrap=True)
        outcome = _run(batch, jobs or cores(), messages, run, output.report)
        refused = batch.publish(outcome)
        for failure in outcome.failures:
            _say(failure, messages)
        for error in refused:
            complain(error)
        status = _status(outcome, batch, refused, messages)
        afterwards = [_tell(folder, messages, output) for folder in batch.written(outcome)]
    return status or _worst(afterwards)


def _worst(statuses: Iterable[int]) -> int:
    """Return the exit status of several: that of a machine that failed comes before that of a user who erred."""
    return min((status for status in statuses if status), default=0)


def _run(batch: Batch, jobs: int, messages: Console, run: Run | None, report: bool) -> Outcome:
    # What shows the tables takes a while to import; there is time for that now.
    for name in ("gpsec.outcomes.summary", *(["gpsec.report.make"] if report else [])):
        Thread(target=import_module, args=(name,)).start()
    with display(messages, batch.names) as show:
        return batch.run(jobs, show, run)


def _check_names(scenarios: Sequence[Scenario], arguments: Sequence[str]) -> None:
    seen: dict[str, str] = {}
    for scenario, argument in zip(scenarios, arguments, strict=True):
        if scenario.name in seen:
            raise GpsecError(
                f"{argument}: scenario '{scenario.name}' has the name of {seen[scenario.name]}; "
                "give one of them another `name`, or run them one after the other"
            )
        seen[scenario.name] = argument


def _say(failure: Failure, messages: Console) -> None:
    if failure.details:
        messages.print(failure.details.rstrip(), markup=False, highlight=False, soft_wrap=True)
    line = " ".join(f"gpsec: error: scenario '{failure.scenario}': {failure.sentence}".split())
    messages.print(line, markup=False, highlight=False, soft_wrap=True)


def _tell(folder: Path, messages: Console, output: Output) -> int:
    """Show the tables of a run and write what is made of them; return the exit status.

    The results stand already: what goes wrong now does not take them away, nor what else is to be made.
    """
    steps: list[Callable[[], None]] = [lambda: _show(folder)]
    if output.parquet:
        steps.append(lambda: _write_parquet(folder))
    if output.report:
        steps.append(lambda: _report(folder, messages))
    found = []
    for step in steps:
        try:
            step()
        except GpsecError as error:
            found.append(complain(error))
    return _worst(found)


def _show(folder: Path) -> None:
    from gpsec.outcomes.summary import print_summary

    # The tables are laid out for this width, also in a file or a pipe.
    with in_a_sentence("the tables cannot be shown"):
        print_summary(folder, terminal.tables(120))


def _write_parquet(folder: Path) -> None:
    from gpsec.running.results import load, write_parquet

    with in_a_sentence(f"{folder}: no Parquet files can be written there"):
        write_parquet(load(folder))


def _report(folder: Path, messages: Console) -> None:
    from gpsec.report.make import write_report
    from gpsec.running.results import load

    with in_a_sentence(f"{folder}: no report can be written there"):
        path = write_report(load(folder))
    messages.print(f"gpsec: report: {path}", markup=False, highlight=False, soft_wrap=True)


def _status(outcome: Outcome, batch: Batch, refused: Sequence[GpsecError], messages: Console) -> int:
    """Say what has been kept of a run that is not complete, and return the exit status."""
    misplaced = any(isinstance(error, MachineError) for error in refused)
    if outcome.interrupted or outcome.failures or misplaced:
        kept = [str(folder) for folder in batch.written(outcome) if folder in batch.missing]
        what = "interrupted" if outcome.interrupted else "not all scenarios finished"
        names = ", ".join(outcome.finished)
        line = f"{names} kept in {', '.join(kept)}; --resume goes on" if kept else "nothing has been written"
        if misplaced:
            what, line = "not all is in its place", "what has been made is kept; --resume goes on"
        messages.print(f"gpsec: {what}; {line}", markup=False, highlight=False, soft_wrap=True)
    if outcome.interrupted:
        return INTERRUPTED
    return _worst([*(failure.kind.status for failure in outcome.failures), *(error.status for error in refused)])
