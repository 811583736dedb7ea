"""`gpsec train`: bars on a terminal, plain lines elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from gpsec.core.progress import DONE
from gpsec.training import TrainingProgress


@contextmanager
def display(console: Console) -> Iterator[Callable[[TrainingProgress], None]]:
    """Give what shows how far the training is."""
    if not console.is_terminal:
        yield _Lines(console)
        return
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[stage]}"),
        TimeElapsedColumn(),
        console=console,
    ) as bars:
        yield _Bars(bars)


class _Bars:
    """A bar for each model in the making, and one for all of them."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, progress: TrainingProgress) -> None:
        if progress.name not in self._tasks:
            self._tasks[progress.name] = self._bars.add_task(progress.name, total=progress.total, stage=progress.stage)
        task = self._tasks[progress.name]
        self._bars.update(task, completed=progress.done, total=progress.total, stage=progress.stage)
        if progress.stage == DONE:
            self._bars.remove_task(self._tasks.pop(progress.name))


class _Lines:
    """A line when the stage of a model changes."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._said: dict[str, str] = {}

    def __call__(self, progress: TrainingProgress) -> None:
        if progress.stage and self._said.get(progress.name) != progress.stage:
            self._said[progress.name] = progress.stage
            self._console.print(f"{progress.name}: {progress.stage}", highlight=False)
