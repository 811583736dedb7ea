"""`gpsec train`: benign traffic, residuals of every profile and matching, training, calibration."""

import signal
import tempfile
from collections.abc import Callable, Iterator, Sequence
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

from gpsec import shipped
from gpsec.detection.logs import ResidualLog
from gpsec.detection.models import MATCHINGS, ProfileModel, save
from gpsec.detection.training import SETTLE_S, train_one
from gpsec.errors import GpsecError, nearest
from gpsec.sensors.registry import PROFILES
from gpsec.threads import cores
from gpsec.traffic.options import resolve_options
from gpsec.training.collect import record_traffic, recorded_traffic, residual_log

# None of these is among the networks that results are reported on.
NETWORKS = ("mountain", "suburb", "beltway")
# Runs of each network that thresholds are calibrated on: with all networks, enough for 0.1 false alarms an hour.
CALIBRATION_RUNS = 3
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
        training_seed, calibration_seeds: of the traffic.
    """

    profile: str
    matching: str
    seed: int
    folder: Path
    nets: dict[str, Path]
    training_seed: int
    calibration_seeds: tuple[int, ...]

    @property
    def name(self) -> str:
        """Name in the progress display."""
        return f"{self.profile}/{self.matching}"


def main(seed: int = 1, out: Path | None = None, jobs: int | None = None, networks: Sequence[str] = NETWORKS) -> None:
    """Train every profile and matching on the training networks and write the models to `out`.

    Detectors learn on the traffic of one seed and are calibrated on that of the `CALIBRATION_RUNS` after it. The files
    depend on the seed and the networks, and not on the number of processes.

    Raises:
        GpsecError: there is no such training network, its scenario is not below the current folder, or the models of
            some networks only were to replace those that gpsec comes with.
    """
    for network in networks:
        if network not in NETWORKS:
            raise GpsecError(f"--networks: no training network '{network}': {nearest(network, NETWORKS)}")
    if set(networks) != set(NETWORKS) and out is None:
        raise GpsecError("--networks: models of some networks only need a folder of their own: say --out DIR")
    networks = [network for network in NETWORKS if network in networks]
    console = Console()
    began = perf_counter()
    configs = {network: shipped.scenarios() / network / f"{network}.sumocfg" for network in networks}
    nets = {network: resolve_options(path, seed=seed).net_file for network, path in configs.items()}
    processes = jobs or cores()
    first = (1 + CALIBRATION_RUNS) * seed
    seeds = range(first, first + 1 + CALIBRATION_RUNS)
    with tempfile.TemporaryDirectory(prefix="gpsec-train-") as name, _display(console, name) as display:
        folder = Path(name)
        display.run(
            "traffic",
            processes,
            [
                (network, record_traffic, (configs[network], traffic_seed, folder / f"{network}-{traffic_seed}.npz"))
                for network in networks
                for traffic_seed in seeds
            ],
        )
        work = [Job(p, m, seed, folder, nets, seeds[0], tuple(seeds[1:])) for p in PROFILES for m in MATCHINGS]
        found = display.run("models", processes, [(job.name, train_job, (job,)) for job in work])
        models = {(job.profile, job.matching): model for job, model in zip(work, found, strict=True)}
    save(models, out or MODELS)
    console.print(f"{len(models)} models in {out or MODELS} after {perf_counter() - began:.0f} s")


def train_job(job: Job) -> ProfileModel:
    """Sense the recorded traffic with one profile and matching, train and calibrate."""
    profile = PROFILES[job.profile]

    def logs(*seeds: int) -> list[ResidualLog]:
        runs = [(network, seed) for seed in seeds for network in job.nets]
        collected = []
        for done, (network, seed) in enumerate(runs):
            _tell(job.name, "sensing", done, len(runs))
            recording = recorded_traffic(job.folder / f"{network}-{seed}.npz", job.nets[network])
            collected.append(residual_log(recording, job.nets[network], network, profile, job.matching, seed))
        return collected

    def progress(stage: str, done: int, total: int) -> None:
        _tell(job.name, stage, done, total)

    return train_one(logs(job.training_seed), logs(*job.calibration_seeds), job.seed, SETTLE_S, progress)


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
    """Runs batches of work in processes and shows how far they are: bars on a terminal, plain lines elsewhere."""

    def __init__(self, console: Console, bars: Progress | None, folder: str) -> None:
        self._console = console
        self._bars = bars
        self._folder = folder
        self._tasks: dict[str, TaskID] = {}
        self._said: dict[str, str] = {}

    def run(self, title: str, processes: int, work: list[tuple[str, Callable[..., Any], tuple[Any, ...]]]) -> list[Any]:
        """Return the results of the calls in `work`, in order; each runs in a fresh process (libsumo needs it)."""
        context = get_context("spawn")
        queue = context.Queue()
        self._show(title, "", 0, len(work))
        with ProcessPoolExecutor(
            processes, mp_context=context, initializer=_listen, initargs=(queue, self._folder), max_tasks_per_child=1
        ) as pool:
            futures: list[Future[Any]] = [pool.submit(call, *arguments) for _, call, arguments in work]
            finished = 0
            try:
                while finished < len(work):
                    self._drain(queue, 0.2)
                    done = [future for future in futures if future.done()]
                    if len(done) > finished:
                        self._show(title, f"{len(done)} of {len(work)} done", len(done), len(work))
                    finished = len(done)
                    for future in done:
                        future.result()
                self._drain(queue, 0.0)
            except BaseException:
                # An interrupt, or a job that failed: the pool would first work through all that is left.
                pool.shutdown(wait=False, cancel_futures=True)
                for child in active_children():
                    child.kill()
                raise
        for name, *_ in work:
            if self._bars is not None and name in self._tasks:
                self._bars.remove_task(self._tasks.pop(name))
        return [future.result() for future in futures]

    def _show(self, name: str, stage: str, done: int, total: int) -> None:
        if self._bars is None:
            if stage and self._said.get(name) != stage:
                self._said[name] = stage
                self._console.print(f"{name}: {stage}", highlight=False)
            return
        if name not in self._tasks:
            self._tasks[name] = self._bars.add_task(name, total=total, stage=stage)
        self._bars.update(self._tasks[name], completed=done, total=total, stage=stage)

    def _drain(self, queue: Any, timeout_s: float) -> None:
        try:
            name, stage, done, total = queue.get(timeout=timeout_s) if timeout_s else queue.get_nowait()
        except Empty:
            return
        self._show(name, stage, done, total)
        self._drain(queue, 0.0)


@contextmanager
def _display(console: Console, folder: str) -> Iterator[_Display]:
    if not console.is_terminal:
        yield _Display(console, None, folder)
        return
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[stage]}"),
        TimeElapsedColumn(),
        console=console,
    ) as bars:
        yield _Display(console, bars, folder)
