"""`gpsec paper`: one bar for all runs, and what came of it."""

from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress

from gpsec.console.bars import Lines
from gpsec.console.complaint import say
from gpsec.console.terminal import messages
from gpsec.core.errors import GpsecError
from gpsec.core.progress import DONE, Progress
from gpsec.core.threads import cores
from gpsec.paper.command import RUNS, make
from gpsec.paper.studies import EVALUATION, TRAINING, Studies
from gpsec.running.workshop import occupied


def make_paper(out: Path, scenarios: Path, quick: bool, jobs: int | None) -> None:
    """Make the tables in `out`.

    Raises:
        GpsecError: the scenarios are not there, one cannot be run, or `out` cannot be written.
        KeyboardInterrupt: the user has had enough; the same call goes on from there.
    """
    for network in (*TRAINING, *EVALUATION):
        if not (scenarios / network).is_dir():
            raise GpsecError(f"{scenarios / network}: expected a scenario of gpsec here; leave --dir out")
    console = messages()
    studies = Studies(scenarios, quick)
    with (
        occupied(out / RUNS, out),
        Bar(console, studies.count) if console.is_terminal else Lines(console) as show,
    ):
        make(out, studies, jobs or cores(), show)
    say(f"{out}: table1.csv to table4.csv, README.md, figures")


class Bar:
    """One bar for a number of runs."""

    def __init__(self, console: Console, runs: int) -> None:
        self._console = console
        self._bar = RichProgress(
            SpinnerColumn(),
            BarColumn(bar_width=32),
            MofNCompleteColumn(),
            TextColumn("{task.description}", markup=False),
            TimeElapsedColumn(),
            console=console,
        )
        self._task = self._bar.add_task("", total=runs)

    def __call__(self, progress: Progress) -> None:
        """Show a report."""
        if progress.note:
            self._console.print(f"{progress.scenario}: {progress.note}", markup=False)
        done = float(progress.stage == DONE)
        self._bar.update(self._task, advance=done, description=f"{progress.scenario}: {progress.stage}")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()
