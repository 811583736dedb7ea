"""`gpsec train`: benign traffic, residuals of every profile and matching, training, calibration."""

import signal
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from pathlib import Path
from queue import Empty
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from gpsec.detection.models import MATCHINGS, ProfileModel, save
from gpsec.detection.training import SETTLE_S, train_one
from gpsec.errors import GpsecError
from gpsec.sensors.registry import PROFILES
from gpsec.threads import cores
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import Recording
from gpsec.training.collect import record_traffic, residual_log

# None of these is among the networks that results are reported on.
NETWORKS = ("mountain", "suburb", "beltway")
SCENARIOS = Path("scenarios")
MODELS = Path(__file__).resolve().parents[1] / "models"

_told: Any = None


@dataclass(frozen=True)
class Job:
    """One profile and matching.

    Attributes:
        profile, matching: what is trained.
        seed: of noise and training.
        folder: where the recordings lie, as ``<network>-<seed>.npz``.
        nets: net file of each network.
        training_seed, calibration_seed: of the traffic.
    """

    profile: str
    matching: str
    seed: int
    folder: Path
    nets: dict[str, Path]
    training_seed: int
    calibration_seed: int

    @property
    def name(self) -> str:
        """Name in the progress display."""
        return f"{self.profile}/{self.matching}"


def main(seed: int = 1, out: Path | None = None, jobs: int | None = None) -> None:
    """Train every profile and matching on the training networks and write the models to `out`.

    Detectors learn on the traffic of one seed and are calibrated on that of the next one. The files depend on the
    seed and not on the number of processes.

    Raises:
        GpsecError: the scenarios of the training networks are not below the current folder.
    """
    console = Console()
    began = perf_counter()
    configs = {network: SCENARIOS / network / f"{network}.sumocfg" for network in NETWORKS}
    for path in configs.values():
        if not path.is_file():
            raise GpsecError(f"{path}: expected a training scenario here; run gpsec train in a checkout of gpsec")
    nets = {network: resolve_options(path, seed=seed).net_file for network, path in configs.items()}
    processes = jobs or cores()
    seeds = (2 * seed, 2 * seed + 1)
    with tempfile.TemporaryDirectory(prefix="gpsec-train-") as name, _display(console, name) as display:
        folder = Path(name)
        display.run(
            "traffic",
            processes,
            [
                (network, record_traffic, (configs[network], traffic_seed, folder / f"{network}-{traffic_seed}.npz"))
                for network in NETWORKS
                for traffic_seed in seeds
            ],
        )
        work = [Job(p, m, seed, folder, nets, *seeds) for p in PROFILES for m in MATCHINGS]
        found = display.run("models", processes, [(job.name, train_job, (job,)) for job in work])
        models = {(job.profile, job.matching): model for job, model in zip(work, found, strict=True)}
    save(models, out or MODELS)
    console.print(f"{len(models)} models in {out or MODELS} after {perf_counter() - began:.0f} s")


def train_job(job: Job) -> ProfileModel:
    """Sense the recorded traffic with one profile and matching, train and calibrate."""
    profile = PROFILES[job.profile]

    def logs(seed: int) -> list[Any]:
        collected = []
        for done, network in enumerate(NETWORKS):
            _tell(job.name, "sensing", done, len(NETWORKS))
            recording = Recording.load(job.folder / f"{network}-{seed}.npz")
            collected.append(residual_log(recording, job.nets[network], network, profile, job.matching, seed))
        return collected

    def progress(stage: str, done: int, total: int) -> None:
        _tell(job.name, stage, done, total)

    return train_one(logs(job.training_seed), logs(job.calibration_seed), job.seed, SETTLE_S, progress)


def _tell(name: str, stage: str, done: int, total: int) -> None:
    if _told is not None:
        _told.put((name, stage, done, total))


def _listen(queue: Any, folder: str) -> None:
    """Be a worker whose progress goes to `queue`, and whose files go away with `folder`."""
    tempfile.tempdir = folder
    global _told
    _told = queue
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    import torch

    torch.set_num_threads(1)


class _Display:
    """Runs batches of work in processes and shows how far they are."""

    def __init__(self, bars: Progress, folder: str) -> None:
        self._bars = bars
        self._folder = folder

    def run(self, title: str, processes: int, work: list[tuple[str, Callable[..., Any], tuple[Any, ...]]]) -> list[Any]:
        """Return the results of the calls in `work`, in order; each runs in a fresh process (libsumo needs it)."""
        context = get_context("spawn")
        queue = context.Queue()
        whole = self._bars.add_task(title, total=len(work), stage="")
        tasks: dict[str, TaskID] = {}
        with ProcessPoolExecutor(
            processes, mp_context=context, initializer=_listen, initargs=(queue, self._folder), max_tasks_per_child=1
        ) as pool:
            futures: list[Future[Any]] = [pool.submit(call, *arguments) for _, call, arguments in work]
            try:
                while not all(future.done() for future in futures):
                    self._drain(queue, tasks, 0.2)
                    finished = [future for future in futures if future.done()]
                    self._bars.update(whole, completed=len(finished))
                    for future in finished:
                        future.result()
                self._drain(queue, tasks, 0.0)
            except BaseException:
                # An interrupt, or a job that failed: the pool would first work through all that is left.
                pool.shutdown(wait=False, cancel_futures=True)
                for child in active_children():
                    child.kill()
                raise
        self._bars.update(whole, completed=len(work))
        for task in tasks.values():
            self._bars.remove_task(task)
        return [future.result() for future in futures]

    def _drain(self, queue: Any, tasks: dict[str, TaskID], timeout_s: float) -> None:
        try:
            name, stage, done, total = queue.get(timeout=timeout_s) if timeout_s else queue.get_nowait()
        except Empty:
            return
        if name not in tasks:
            tasks[name] = self._bars.add_task(name, total=total, stage=stage)
        self._bars.update(tasks[name], completed=done, total=total, stage=stage)
        self._drain(queue, tasks, 0.0)


@contextmanager
def _display(console: Console, folder: str) -> Iterator[_Display]:
    bars = Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[stage]}"),
        TimeElapsedColumn(),
        console=console,
    )
    with bars:
        yield _Display(bars, folder)
