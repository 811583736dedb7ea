"""The list of a sweep on Dask: each simulation is a task of a cluster, and ends up in the store all the same.

Workers need the disk that the sweep lies on. The cluster only says who runs what; what is done is what is in the store,
so that nothing is lost with a worker, the scheduler or the client.
"""

import logging
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from gpsec.core.errors import GpsecError, MachineError, shown
from gpsec.core.progress import DONE, FAILED, Progress, Report
from gpsec.core.system import in_a_sentence
from gpsec.pipeline.fingerprint import environment_digest
from gpsec.running.task_process import Failure, Run
from gpsec.sweeps.desk import note_failure, run_as_listed
from gpsec.sweeps.folder import SweepFolder
from gpsec.sweeps.on_worker import TOPIC, about, run_one
from gpsec.sweeps.work import Worked

if TYPE_CHECKING:
    from distributed import Client

# Tasks that the scheduler has at a time, for each worker: enough that none waits, few enough that memory stays flat.
_AHEAD = 3
# A machine's fault may be that of one machine.
_MOST_TRIES = 3
_WAIT_S = 60.0
# Workers come and go; who they are is asked for so often, since the answer takes as long as several tasks.
_ASK_S = 2.0
# What a scheduler remembers of messages and transitions, for those who work on Dask: 1,000 of each would be 10 MB here.
_SHORT_LOGS = {"distributed.admin.low-level-log-length": 100}


@contextmanager
def connected(address: str, jobs: int) -> "Iterator[Client]":
    """Give a client of the cluster at an address, or in a scheduler file; ``local`` starts one with `jobs` workers.

    Raises:
        GpsecError: Dask is not installed, or there is no scheduler.
    """
    try:
        from dask import config
        from distributed import Client, LocalCluster
    except ImportError:
        raise GpsecError(
            "--scheduler: expected Dask, found it is not installed; `pip install 'gpsec[sweep]'` does"
        ) from None
    logging.getLogger("distributed").setLevel(logging.ERROR)  # what is to be said we say in a sentence
    if address == "local":
        # SUMO is a process below the worker, which its memory limit would not see.
        with (
            config.set(_SHORT_LOGS),
            LocalCluster(n_workers=jobs, threads_per_worker=1, memory_limit=0, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    where = {"scheduler_file": address} if Path(address).is_file() else {"address": address}
    try:
        client = Client(**where, timeout=10.0)
    except (OSError, ValueError, TypeError) as error:
        said = shown(str(error).partition("\n")[0])
        raise GpsecError(f"--scheduler {address}: expected a scheduler of Dask there, found none ({said})") from None
    with client:
        yield client


def work_on(
    client: "Client", sweep: SweepFolder, fingerprints: list[str], report: Report, run: Run = run_as_listed
) -> Worked:
    """Make what is missing of the given simulations on a cluster.

    A worker with other code or libraries, without the disk or without a part that a scenario names, is refused. What a
    machine is at fault for is tried on another one.

    Raises:
        GpsecError: every worker is refused, or the scheduler is gone; what is done is kept.
    """
    sweep.store.sweep_up()
    return _Dispatch(client, sweep, fingerprints, report, run).work()


class _Given(NamedTuple):
    """A task that was handed out, and to whom; to anybody where there is no worker."""

    fingerprint: str
    workers: tuple[str, ...]


class _Dispatch:
    """What is waiting, at work and refused."""

    def __init__(self, client: "Client", sweep: SweepFolder, fingerprints: list[str], report: Report, run: Run) -> None:
        self._client = client
        self._run = run
        self._sweep = sweep
        self._report = report
        self._waiting = [each for each in reversed(fingerprints) if not sweep.store.has(each)]
        self._tries: Counter[str] = Counter()
        self._at_work: dict[Any, _Given] = {}
        self._refused: dict[str, str] = {}
        self._failures: list[Failure] = []
        self._where: dict[str, set[str]] = {}
        self._known: tuple[str, ...] = ()
        self._seen: set[str] = set()
        self._asked_s = 0.0

    def work(self) -> Worked:
        """Hand out and collect until all is done."""
        self._client.subscribe_topic(TOPIC, self._tell)
        try:
            while self._waiting or self._at_work:
                self._submit()
                for future in self._some_ended():
                    self._ended(self._at_work.pop(future).fingerprint, future)
                    future.release()
                self._take_back()
        except KeyboardInterrupt:
            self._client.cancel(list(self._at_work))
            return Worked(self._failures, interrupted=True)
        finally:
            if self._client.status == "running":
                self._client.unsubscribe_topic(TOPIC)
        return Worked(self._failures)

    def _some_ended(self) -> list[Any]:
        """Wait for tasks that have ended, for some time; return them."""
        from distributed import CancelledError, wait

        with suppress(TimeoutError, CancelledError):  # who is cancelled has ended, too
            wait(list(self._at_work), timeout=_ASK_S, return_when="FIRST_COMPLETED")
        return [future for future in self._at_work if future.done()]

    def _take_back(self) -> None:
        """Take back tasks that are for workers only which are gone: Dask would keep them for these."""
        alive = set(self._alive())
        for future, given in list(self._at_work.items()):
            if given.workers and alive.isdisjoint(given.workers) and not future.done():
                del self._at_work[future]
                future.cancel()
                self._tries[given.fingerprint] -= 1
                self._waiting.append(given.fingerprint)

    def _look(self, addresses: list[str]) -> None:
        """Refuse those of some workers that are not as we are."""
        here = environment_digest()
        told = self._client.run(about, str(self._sweep.path), workers=addresses, on_error="return")
        for address, said in told.items():
            if isinstance(said, Exception):
                self._refuse(address, f"cannot be used: it does not find gpsec there ({shown(said)})")
            elif said != here:
                unfit = str(said).startswith("cannot")
                self._refuse(address, said if unfit else f"has other code or libraries ({said[:12]}, here {here[:12]})")

    def _refuse(self, address: str, why: str) -> None:
        if address not in self._refused:
            self._refused[address] = why
            self._report(Progress(f"worker {address}", note=f"refused: {why}"))

    def _submit(self) -> None:
        """Hand out what the workers may soon run."""
        alive = self._workers()
        while self._waiting and len(self._at_work) < _AHEAD * len(alive):
            fingerprint = self._waiting.pop()
            self._tries[fingerprint] += 1
            tried = self._where.get(fingerprint, ())
            own: tuple[str, ...] = ()
            if tried or self._refused:
                own = tuple(each for each in alive if each not in tried) or tuple(alive)
            arguments = (str(self._sweep.path), fingerprint, self._sweep.labels[fingerprint], self._run)
            allowed = self._sweep.allow_code
            future = self._client.submit(run_one, *arguments, allowed, workers=own or None, pure=False, retries=0)
            self._at_work[future] = _Given(fingerprint, own)

    def _workers(self) -> list[str]:
        """Return the workers that may be used; wait for some where there are none yet, as on a cluster that starts.

        Raises:
            GpsecError: there are only such as are refused, or none come.
        """
        found = self._alive()
        if not found:
            with suppress(TimeoutError):
                self._client.wait_for_workers(len(self._refused) + 1, timeout=_WAIT_S)
            self._known = ()
            found = self._alive()
        if not found and not self._at_work:
            reasons = "; ".join(f"{address} {why}" for address, why in self._refused.items())
            said = f"every worker is refused: {reasons}" if reasons else f"no worker came within {_WAIT_S:.0f} s"
            raise GpsecError(f"{self._sweep.path}: nothing can be run on this cluster: {said}")
        return found

    def _alive(self) -> list[str]:
        now_s = time.monotonic()
        if not self._known or now_s - self._asked_s > _ASK_S:
            found = tuple(self._client.scheduler_info(n_workers=-1)["workers"])
            if new := [address for address in found if address not in self._seen]:
                self._seen |= set(new)
                self._look(new)
            self._known, self._asked_s = found, now_s
        return [address for address in self._known if address not in self._refused]

    def _ended(self, fingerprint: str, future: Any) -> None:
        """Note what became of a task."""
        label = self._sweep.labels[fingerprint]
        if future.status == "finished":
            said = future.result()
            if said["state"] == "unfit":
                self._refuse(said["worker"], said["sentence"])
                self._tries[fingerprint] -= 1
                self._waiting.append(fingerprint)
                return
            if said["state"] == "done":
                self._report(Progress(label, stage=DONE))
                return
            failure = Failure(label, said["sentence"], said["details"], MachineError if said["machine"] else GpsecError)
            self._where.setdefault(fingerprint, set()).add(said["worker"])
        elif future.status == "error":  # several workers were gone while they had it, or it could not be told to one
            failure = Failure(label, f"its worker ended early: {shown(future.exception())}", "", MachineError)
        else:
            raise MachineError(
                f"{self._sweep.path}: the scheduler is gone; what is done is kept, and the same command goes on"
            )
        if issubclass(failure.kind, MachineError) and self._tries[fingerprint] < _MOST_TRIES:
            self._waiting.insert(0, fingerprint)
            return
        with in_a_sentence(f"{self._sweep.path}: cannot be written"):
            note_failure(self._sweep, fingerprint, failure)
        self._failures.append(failure)
        self._report(Progress(label, stage=FAILED))

    def _tell(self, event: tuple[float, Any]) -> None:
        """Pass on what a task tells of itself."""
        told = event[1]
        if isinstance(told, dict) and told.get("sweep") == str(self._sweep.path):
            self._report(Progress(**told["progress"]))
