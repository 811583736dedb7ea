"""Progress of scenarios: bars on a terminal, a plain line now and then elsewhere."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress

from gpsec.core.progress import DONE, FAILED, Progress

# Between the lines on one stage of a scenario: the first ones come soon, for short runs.
_FIRST_LINE_S, _LINE_EVERY_S = 1.0, 15.0


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


class Counted:
    """What is counted, one thing after the other: a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bars = RichProgress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console,
            disable=not console.is_terminal,
        )

    def begin(self, name: str) -> Callable[[int, int], None]:
        """Begin to count something; what is returned takes how many are done, of how many."""
        task = self._bars.add_task(name, total=None)
        told = _Told(name, time.monotonic(), _FIRST_LINE_S)

        def tell(done: int, of: int) -> None:
            self._bars.update(task, completed=done, total=of)
            now_s = time.monotonic()
            if not self._console.is_terminal and (done == of or now_s - told.said_s >= told.pause_s):
                told.said_s, told.pause_s = now_s, min(2.0 * told.pause_s, _LINE_EVERY_S)
                self._console.print(f"{name}: {done}/{of}", markup=False, highlight=False, soft_wrap=True)

        return tell

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()


class Lines:
    """A line when a stage of a scenario begins and ends, and now and then in between: soon at first, later seldom."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._told: dict[str, _Told] = {}

    def __call__(self, progress: Progress) -> None:
        """Show a report, if its time has come."""
        told, now_s = self._told.get(progress.scenario), time.monotonic()
        if progress.note:
            self._say(f"{progress.scenario}: {progress.note}")
        if told is None or told.stage != progress.stage:
            if told is not None and told.unsaid is not None:
                self._say(f"{progress.scenario}: {_numbers(told.unsaid)}")
            told = self._told[progress.scenario] = _Told(progress.stage, now_s, _FIRST_LINE_S)
        elif now_s - told.said_s >= told.pause_s:
            told.said_s, told.pause_s, told.unsaid = now_s, min(2.0 * told.pause_s, _LINE_EVERY_S), None
        else:
            told.unsaid = progress
            return
        self._say(f"{progress.scenario}: {_numbers(progress)}")

    def _say(self, line: str) -> None:
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return


@dataclass
class _Told:
    """What was said last of a scenario: its stage, when, the pause after it, and what has been heard since."""

    stage: str
    said_s: float
    pause_s: float
    unsaid: Progress | None = None


def _numbers(progress: Progress) -> str:
    if progress.time_s <= 0.0:
        return progress.stage
    of = f"/{progress.duration_s:.0f}" if progress.duration_s is not None else ""
    return (
        f"{progress.stage}: {progress.time_s:.0f}{of} s, {progress.vehicles} vehicles, {progress.tracks} tracks, "
        f"{progress.real_time_factor:.1f}x real time"
    )
