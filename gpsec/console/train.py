"""`gpsec train`: bars on a terminal, plain lines elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.core.progress import DONE

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

    from gpsec.training import TrainingProgress


def train(
    seed: Annotated[int, typer.Option(metavar="N", help="Of traffic, noise and training.")] = 1,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where models go.")] = Path("models"),
    jobs: Annotated[int | None, typer.Option(min=1, metavar="N", help="Processes. [default: the cores]")] = None,
    networks: Annotated[
        str | None, typer.Option(metavar="A,B", help="Only these training networks. [default: all]")
    ] = None,
    detectors: Annotated[
        list[str] | None,
        typer.Option("--detector", metavar="X", help="Only this detector, and what shares its arrays; repeatable."),
    ] = None,
    profiles: Annotated[
        list[str] | None, typer.Option("--profile", metavar="P", help="Only this sensor profile; repeatable.")
    ] = None,
    part: options.Part = None,
    tapes: options.PlayedTapes = None,
) -> None:
    """Train the learned detectors on benign runs and calibrate every threshold.

    \b
    Examples:
      gpsec train --seed 2 --out /tmp/models
      gpsec train --detector cusum --profile dsd
      gpsec train --part mine.py:OcSvm --detector oc_svm --profile carla
      gpsec train --profile dsd --tape rendered-good --tape rendered-night --out models
      gpsec train --networks mountain,suburb --out /tmp/models
      gpsec run scenarios/town --set detection.models=models
    """  # noqa: D301
    from rich.console import Console

    from gpsec.scenario.networks import TRAINING_NETWORKS
    from gpsec.training import Driving
    from gpsec.training import train as train_models

    chosen = TRAINING_NETWORKS if networks is None else [name.strip() for name in networks.split(",")]
    loaded = options.load_given_parts(part)
    console = Console()
    began = perf_counter()
    with display_training(console) as report:
        made = train_models(
            out,
            detectors=detectors or (),
            profiles=profiles or (),
            driving=Driving(chosen, tapes or ()),
            parts=loaded,
            seed=seed,
            jobs=jobs,
            report=report,
        )
    console.print(f"{len(made)} models in {out} after {perf_counter() - began:.0f} s", highlight=False)


@contextmanager
def display_training(console: "Console") -> "Iterator[Callable[[TrainingProgress], None]]":
    """Give what shows how far the training is."""
    if not console.is_terminal:
        yield _Lines(console)
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

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

    def __init__(self, bars: "Progress") -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, progress: "TrainingProgress") -> None:
        if progress.name not in self._tasks:
            self._tasks[progress.name] = self._bars.add_task(progress.name, total=progress.total, stage=progress.stage)
        task = self._tasks[progress.name]
        self._bars.update(task, completed=progress.done, total=progress.total, stage=progress.stage)
        if progress.stage == DONE:
            self._bars.remove_task(self._tasks.pop(progress.name))


class _Lines:
    """A line when the stage of a model changes."""

    def __init__(self, console: "Console") -> None:
        self._console = console
        self._said: dict[str, str] = {}

    def __call__(self, progress: "TrainingProgress") -> None:
        if progress.stage and self._said.get(progress.name) != progress.stage:
            self._said[progress.name] = progress.stage
            self._console.print(f"{progress.name}: {progress.stage}", highlight=False)
