"""Progress of scenarios: bars on a terminal, a plain line now and then elsewhere."""

import time
from types import TracebackType
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress

from gpsec.core.progress import DONE, FAILED, Progress

_LINE_EVERY_S = 15.0


class Display(Protocol):
    """Shows what scenarios tell, while it is entered as a context."""

    def __call__(self, progress: Progress) -> None: ...  # noqa: D102
    def __enter__(self) -> Self: ...
    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def display(console: Console, names: list[str]) -> Display:
    """Return the display that suits the console."""
    return Bars(console, names) if console.is_terminal else Lines(console)


class Bars:
    """One bar a scenario."""

    def __init__(self, console: Console, names: list[str]) -> None:
        self._console = console
        self._bars = RichProgress(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[numbers]}", markup=False),
            TimeElapsedColumn(),
            console=console,
        )
        self._tasks: dict[str, TaskID] = {
            name: self._bars.add_task(name, total=None, start=False, numbers="waiting") for name in names
        }
        self._started: set[str] = set()

    def __call__(self, progress: Progress) -> None:
        """Show a report."""
        task = self._tasks[progress.scenario]
        if progress.scenario not in self._started:
            self._started.add(progress.scenario)
            self._bars.start_task(task)
        if progress.note:
            self._console.print(f"{progress.scenario}: {progress.note}", markup=False)
        if progress.stage in (DONE, FAILED):
            self._bars.update(task, total=1.0, completed=float(progress.stage == DONE), numbers=progress.stage)
            self._bars.stop_task(task)
            return
        self._bars.update(task, total=progress.duration_s, completed=progress.time_s, numbers=_numbers(progress))

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()


class TotalBar:
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


class Lines:
    """A line when the stage of a scenario changes, and every quarter of a minute."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last: dict[str, tuple[str, float]] = {}

    def __call__(self, progress: Progress) -> None:
        """Show a report, if its time has come."""
        stage, shown_s = self._last.get(progress.scenario, ("", 0.0))
        now_s = time.monotonic()
        if progress.note:
            self._say(f"{progress.scenario}: {progress.note}")
        if progress.stage != stage or now_s - shown_s >= _LINE_EVERY_S:
            self._last[progress.scenario] = (progress.stage, now_s)
            self._say(f"{progress.scenario}: {_numbers(progress)}")

    def _say(self, line: str) -> None:
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return


def _numbers(progress: Progress) -> str:
    if progress.time_s <= 0.0:
        return progress.stage
    of = f"/{progress.duration_s:.0f}" if progress.duration_s is not None else ""
    return (
        f"{progress.stage}: {progress.time_s:.0f}{of} s, {progress.vehicles} vehicles, {progress.tracks} tracks, "
        f"{progress.real_time_factor:.1f}x real time"
    )
