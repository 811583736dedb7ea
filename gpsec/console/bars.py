"""Progress of tasks: bars on a terminal, plain lines now and then elsewhere.

There is one display for all that is run many times: what is done, running and failed, the time left, and how far each
of those is that run now.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as RichProgress

from gpsec.console.tally import Tally
from gpsec.core.progress import DONE, FAILED, Progress

# Between the lines on one stage of a scenario: the first ones come soon, for short runs.
_FIRST_LINE_S, _LINE_EVERY_S = 1.0, 15.0
# With more tasks there are bars for those that run now only, and lines for all of them together.
FEW = 8


class Display(Protocol):
    """Shows what tasks tell, while it is entered as a context."""

    def __call__(self, progress: Progress) -> None: ...  # noqa: D102
    def __enter__(self) -> Self: ...
    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def display(console: Console, count: int) -> Display:
    """Return the display of so many tasks that suits the console."""
    if console.is_terminal:
        return Bars(console, count)
    return Lines(console) if count <= FEW else TallyLines(console, count)


class Bars:
    """A bar for each task that runs, and one for all where there are several."""

    def __init__(self, console: Console, count: int) -> None:
        self._console = console
        self._few = count <= FEW
        self._tally = Tally(count)
        self._bars = RichProgress(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[numbers]}", markup=False),
            TimeElapsedColumn(),
            console=console,
        )
        self._all = self._bars.add_task("all", total=count, numbers="") if count > 1 else None
        self._tasks: dict[str, TaskID] = {}
        self._said: set[str] = set()

    def __call__(self, progress: Progress) -> None:
        """Show a report."""
        self._tally.add(progress)
        if progress.note and (self._few or progress.note not in self._said):
            self._said.add(progress.note)
            self._console.print(f"{progress.scenario}: {progress.note}", markup=False)
        if self._all is not None:
            self._bars.update(self._all, completed=self._tally.ended, numbers=self._tally.text())
        task = self._tasks.get(progress.scenario)
        if task is None:
            if progress.stage in (DONE, FAILED) and not self._few:
                return
            task = self._tasks[progress.scenario] = self._bars.add_task(progress.scenario, total=None, numbers="")
        if progress.stage not in (DONE, FAILED):
            self._bars.update(task, total=progress.duration_s, completed=progress.time_s, numbers=_numbers(progress))
        elif self._few:
            self._bars.update(task, total=1.0, completed=float(progress.stage == DONE), numbers=progress.stage)
            self._bars.stop_task(task)
        else:
            self._bars.remove_task(self._tasks.pop(progress.scenario))

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()


class TallyLines:
    """A line on all tasks now and then: soon at first, later seldom; one on each that fails."""

    def __init__(self, console: Console, count: int) -> None:
        self._console = console
        self._tally = Tally(count)
        self._said: set[str] = set()
        self._said_s, self._pause_s = time.monotonic(), _FIRST_LINE_S

    def __call__(self, progress: Progress) -> None:
        """Show a report, if its time has come."""
        self._tally.add(progress)
        if progress.note and progress.note not in self._said:
            self._said.add(progress.note)
            self._say(f"{progress.scenario}: {progress.note}")
        if progress.stage == FAILED:
            self._say(f"{progress.scenario}: {FAILED}")
        now_s = time.monotonic()
        if now_s - self._said_s >= self._pause_s:
            self._said_s, self._pause_s = now_s, min(2.0 * self._pause_s, _LINE_EVERY_S)
            self._say(self._tally.text())

    def _say(self, line: str) -> None:
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._say(self._tally.text())


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
