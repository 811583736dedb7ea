"""`gpsec train`: benign traffic, residuals of every profile and matching, training, calibration."""

import signal
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import active_children
from pathlib import Path
from queue import Empty
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from gpsec.core import shipped
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.processes import SPAWN
from gpsec.core.threads import cores
from gpsec.detection.logs import ResidualLog
from gpsec.detection.models import MATCHINGS, ProfileModel, bundled, load, save
from gpsec.detection.registry import DETECTORS
from gpsec.detection.training import SETTLE_S, merged, related, train_one
from gpsec.scenario.parts import use
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.options import resolve_options
from gpsec.training.collect import record_traffic, recorded_traffic, residual_log

# None of these is among the networks that results are reported on.
NETWORKS = ("mountain", "suburb", "beltway")
# Runs of each network that thresholds are calibrated on: with all networks, enough for 0.1 false alarms an hour.
CALIBRATION_RUNS = 3

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
        detectors: those that are trained and calibrated.
        parts: from outside gpsec.
    """

    profile: str
    matching: str
    seed: int
    folder: Path
    nets: dict[str, Path]
    training_seed: int
    calibration_seeds: tuple[int, ...]
    detectors: tuple[str, ...] = DETECTORS.own
    parts: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in the progress display."""
        return f"{self.profile}/{self.matching}"


@dataclass(frozen=True)
class Wanted:
    """What is trained.

    Attributes:
        networks: of `NETWORKS`.
        profiles: sensor profiles; none stands for all of gpsec's own.
        detectors: with those that share arrays with them; none stands for all of gpsec's own.
        parts: from outside gpsec, by their references with whole paths, loaded already.
    """

    networks: Sequence[str] = NETWORKS
    profiles: Sequence[str] = ()
    detectors: Sequence[str] = ()
    parts: tuple[str, ...] = ()

    def resolved(self) -> tuple[list[str], tuple[str, ...], tuple[str, ...]]:
        """Return networks, profiles and detectors, in the order in which they are trained.

        Raises:
            GpsecError: there is none of such a name.
        """
        for network in self.networks:
            if network not in NETWORKS:
                raise GpsecError(f"--networks: no training network '{shown(network)}': {nearest(network, NETWORKS)}")
        networks = [network for network in NETWORKS if network in self.networks]
        profiles = tuple(PROFILES[name].name for name in self.profiles) or PROFILES.own
        return networks, profiles, related(self.detectors) if self.detectors else DETECTORS.own


def main(seed: int = 1, out: Path = Path("models"), jobs: int | None = None, wanted: Wanted | None = None) -> None:
    """Train on the training networks and write the models to `out`, each as soon as it is done.

    Detectors learn on the traffic of one seed and are calibrated on that of the `CALIBRATION_RUNS` after it. The files
    depend on the seed and on what is wanted, and not on the number of processes. What is not trained is taken from the
    models that `out` holds, else, where all networks are trained on, from those that gpsec comes with.

    Raises:
        GpsecError: there is no such network, profile or detector, or `out` holds something else than models.
    """
    wanted = wanted or Wanted()
    networks, profiles, detectors = wanted.resolved()
    models = _former(out, whole=len(networks) == len(NETWORKS))
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
        lasting = (detectors, wanted.parts)
        work = [
            Job(profile, matching, seed, folder, nets, seeds[0], tuple(seeds[1:]), *lasting)
            for profile in profiles
            for matching in MATCHINGS
        ]

        def keep(place: int, model: ProfileModel) -> None:
            key = work[place].profile, work[place].matching
            models[key] = merged(models.get(key), model)
            save(models, out)

        display.run("models", processes, [(job.name, train_job, (job,)) for job in work], keep)
    console.print(f"{len(work)} models in {out} after {perf_counter() - began:.0f} s", highlight=False)


def _former(out: Path, *, whole: bool) -> dict[tuple[str, str], ProfileModel]:
    """Return the models that what is not trained is taken from, with their arrays read."""
    found = load(out) if out.is_dir() and any(out.iterdir()) else bundled() if whole else {}
    return {key: replace(model, learned=dict(model.learned)) for key, model in found.items()}


def train_job(job: Job) -> ProfileModel:
    """Sense the recorded traffic with one profile and matching, train and calibrate."""
    use(job.parts)
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

    training, calibration = logs(job.training_seed), logs(*job.calibration_seeds)
    return train_one(training, calibration, job.seed, SETTLE_S, progress, detectors=job.detectors)


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

    def run(
        self,
        title: str,
        processes: int,
        work: list[tuple[str, Callable[..., Any], tuple[Any, ...]]],
        keep: Callable[[int, Any], None] = lambda place, result: None,
    ) -> list[Any]:
        """Return the results of the calls in `work`, in order; each runs in a fresh process (libsumo needs it).

        `keep` is told each result with its place in `work`, as soon as it is there.
        """
        queue = SPAWN.Queue()
        self._show(title, "", 0, len(work))
        with ProcessPoolExecutor(
            processes, mp_context=SPAWN, initializer=_listen, initargs=(queue, self._folder), max_tasks_per_child=1
        ) as pool:
            futures: list[Future[Any]] = [pool.submit(call, *arguments) for _, call, arguments in work]
            finished: set[int] = set()
            try:
                while len(finished) < len(work):
                    self._drain(queue, 0.2)
                    new = [place for place, future in enumerate(futures) if future.done() and place not in finished]
                    for place in new:
                        keep(place, futures[place].result())
                        finished.add(place)
                    if new:
                        self._show(title, f"{len(finished)} of {len(work)} done", len(finished), len(work))
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
