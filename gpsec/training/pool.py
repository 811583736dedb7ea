"""Processes that train, and how far they are."""

import signal
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import active_children
from pathlib import Path
from queue import Empty
from typing import Any, NamedTuple

from gpsec.core.processes import SPAWN
from gpsec.core.progress import DONE

Call = tuple[str, Callable[..., Any], tuple[Any, ...]]
"""Name in the progress, a function of a module, its arguments."""

_LOOK_S = 0.02
_told: Any = None


class TrainingProgress(NamedTuple):
    """How far a part of the training is.

    Attributes:
        name: of the part: `traffic` and `models` stand for all of it, ``profile/association`` for one model.
        stage: what is being done; `gpsec.core.progress.DONE` once it is over.
        done, total: of the steps of this stage; equal when it is over.
    """

    name: str
    stage: str
    done: int
    total: int


@dataclass(frozen=True)
class Pool:
    """Processes for batches of calls.

    Attributes:
        processes: their number.
        folder: for files that go away.
        report: called with how far they are.
    """

    processes: int
    folder: Path
    report: Callable[[TrainingProgress], None]

    def run(
        self, title: str, work: list[Call], keep: Callable[[int, Any], None] = lambda place, result: None
    ) -> list[Any]:
        """Return the results of the calls in `work`, in order; each runs in a fresh process (libsumo needs it).

        `keep` is told each result with its place in `work`, as soon as it is there.
        """
        queue = SPAWN.Queue()
        others = active_children()
        self.report(TrainingProgress(title, "", 0, len(work)))
        with ProcessPoolExecutor(
            self.processes,
            mp_context=SPAWN,
            initializer=_listen,
            initargs=(queue, str(self.folder)),
            max_tasks_per_child=1,
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
                        self.report(TrainingProgress(work[place][0], DONE, 1, 1))
                    if new:
                        said = f"{len(finished)} of {len(work)} done"
                        self.report(TrainingProgress(title, said, len(finished), len(work)))
                self._drain(queue, 0.0)
            except BaseException:
                # An interrupt, or a job that failed: the pool would first work through all that is left.
                _end(futures, others)
                raise
        return [future.result() for future in futures]

    def _drain(self, queue: Any, timeout_s: float) -> None:
        try:
            progress = queue.get(timeout=timeout_s) if timeout_s else queue.get_nowait()
        except Empty:
            return
        self.report(TrainingProgress(*progress))
        self._drain(queue, 0.0)


def _end(futures: list[Future[Any]], others: list[Any]) -> None:
    """Let no call of a pool go on; `others` are the children that are not its own."""
    for future in futures:
        future.cancel()
    # What has been handed out cannot be cancelled, and may be taken by a process that is only being started.
    while not all(future.done() for future in futures):
        for child in set(active_children()).difference(others):
            child.kill()
        time.sleep(_LOOK_S)


def tell_progress(name: str, stage: str, done: int, total: int) -> None:
    """Say in a process of a pool how far it is."""
    if _told is not None:
        _told.put((name, stage, done, total))


def _listen(queue: Any, folder: str) -> None:
    """Be a process whose progress goes to `queue`, and whose files go away with `folder`."""
    tempfile.tempdir = folder
    global _told
    _told = queue
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    import torch

    torch.set_num_threads(1)
