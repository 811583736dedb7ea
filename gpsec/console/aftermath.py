"""What `gpsec run` says and makes once the scenarios have ended."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gpsec.console.errors import INTERRUPTED, complain
from gpsec.console.terminal import Terminal, tables
from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.system import in_a_sentence
from gpsec.outcomes.naming import base_name, scenario_of_world
from gpsec.running.batch import Batch
from gpsec.running.folders import resolved
from gpsec.running.workers import Failure, Outcome
from gpsec.scenario import Scenario

_WIDTH = 120


@dataclass(frozen=True)
class Output:
    """What a run leaves, and where.

    Attributes:
        out: one folder for all scenarios; None gives each its ``results/<name>``.
        overwrite: replace the run that a folder holds.
        resume: go on with what a run that stopped has left.
        report: write ``report.html`` into each folder.
        parquet: write the large tables as Parquet files too.
        tables: print all tables, not only the few lines that say what has been found.
    """

    out: Path | None = None
    overwrite: bool = False
    resume: bool = False
    report: bool = True
    parquet: bool = False
    tables: bool = False

    def groups(self, scenarios: Sequence[Scenario]) -> dict[Path, list[Scenario]]:
        """Return the scenarios of each folder: one for those that differ in their seed, or in their world."""
        if self.out is not None:
            return {resolved(self.out): list(scenarios)}
        found: dict[Path, list[Scenario]] = {}
        for scenario in scenarios:
            found.setdefault(resolved(Path("results") / _folder_name(scenario)), []).append(scenario)
        return found


def _folder_name(scenario: Scenario) -> str:
    if scenario.closed_loop.world is None:
        return base_name(scenario.name)
    return f"{scenario_of_world(scenario.name)}-closed-loop"


def tell(batch: Batch, outcome: Outcome, refused: Sequence[GpsecError], output: Output, messages: Terminal) -> int:
    """Say what went wrong, show the tables, make the pages; return the exit status."""
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


def _say(failure: Failure, messages: Terminal) -> None:
    if failure.details:
        messages.note(failure.details.rstrip())
    line = " ".join(f"gpsec: error: scenario '{failure.scenario}': {failure.sentence}".split())
    messages.note(line)


def _tell(folder: Path, messages: Terminal, output: Output) -> int:
    """Show the tables of a run and write what is made of them; return the exit status.

    The results stand already: what goes wrong now does not take them away, nor what else is to be made.
    """
    steps: list[Callable[[], None]] = [lambda: show_findings(folder, output.tables)]
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


def show_findings(folder: Path, tables_too: bool) -> None:
    """Print what a run has found: in a few lines, or in all its tables; of a closed loop, its worlds."""
    from gpsec.outcomes.brief import print_brief
    from gpsec.outcomes.summary import print_summary
    from gpsec.outcomes.worlds_summary import print_worlds

    # The tables are laid out for this width, also in a file or a pipe.
    with in_a_sentence("the tables cannot be shown"):
        if (folder / "worlds.csv").exists():
            print_worlds(folder, tables(160))
        elif tables_too:
            print_summary(folder, tables(_WIDTH))
        else:
            print_brief(folder, tables(_WIDTH))


def _write_parquet(folder: Path) -> None:
    from gpsec.running.results import load, write_parquet

    with in_a_sentence(f"{folder}: no Parquet files can be written there"):
        write_parquet(load(folder))


def _report(folder: Path, messages: Terminal) -> None:
    from gpsec.report.make import write_report
    from gpsec.running.results import load

    with in_a_sentence(f"{folder}: no report can be written there"):
        path = write_report(load(folder))
    messages.note(f"gpsec: report: {path}")


def _status(outcome: Outcome, batch: Batch, refused: Sequence[GpsecError], messages: Terminal) -> int:
    """Say what has been kept of a run that is not complete, and return the exit status."""
    misplaced = any(isinstance(error, MachineError) for error in refused)
    if outcome.interrupted or outcome.failures or misplaced:
        kept = [str(folder) for folder in batch.written(outcome) if folder in batch.missing]
        what = "interrupted" if outcome.interrupted else "not all scenarios finished"
        names = ", ".join(outcome.finished)
        line = f"{names} kept in {', '.join(kept)}; --resume goes on" if kept else "nothing has been written"
        if misplaced:
            what, line = "not all is in its place", "what has been made is kept; --resume goes on"
        messages.note(f"gpsec: {what}; {line}")
    if outcome.interrupted:
        return INTERRUPTED
    return _worst([*(failure.kind.status for failure in outcome.failures), *(error.status for error in refused)])
