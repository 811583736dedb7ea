"""What runs in a worker of Dask: one simulation of a list, in a process of its own below the worker."""

import time
from dataclasses import asdict
from functools import lru_cache
from multiprocessing import current_process
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.progress import DONE, FAILED, Progress
from gpsec.core.system import in_a_sentence
from gpsec.pipeline.fingerprint import environment_digest
from gpsec.running.workers import Run, run_tasks
from gpsec.sweeps.desk import SweepDesk, run_as_listed
from gpsec.sweeps.folder import LIST, SweepFolder, read_folder
from gpsec.sweeps.work import compile_first

TOPIC = "gpsec"
_TELL_EVERY_S = 1.0
_LOOK_S = 2.0


def about(path: str) -> str:
    """Return the digest of the code and libraries of this worker, or why it is of no use."""
    try:
        read_folder(Path(path)).store.check()
    except GpsecError as error:
        return f"cannot be used: {error}"
    return environment_digest()


def run_one(path: str, fingerprint: str, label: str, run: Run, allow_code: bool) -> dict[str, Any]:
    """Make one simulation of the sweep in a folder; return what became of it, for the client.

    The state is ``done``, ``failed`` or ``unfit``; with it come the sentence, details, whether the machine is at fault,
    and the worker's address.
    """
    from distributed import get_worker

    worker = get_worker()
    # Dask's workers are daemons, which may not have processes. Ours end with their parent, whatever becomes of it.
    current_process().daemon = False
    said: dict[str, Any] = {"state": "done", "sentence": "", "details": "", "machine": True, "worker": worker.address}
    tell = _Teller(worker, path)
    tell(Progress(label, stage="starting"))
    try:
        return said | _made(folder_of(path, allow_code), fingerprint, tell, run)
    except MachineError as error:
        return said | {"state": "failed", "sentence": str(error)}
    except GpsecError as error:
        return said | {"state": "unfit", "sentence": f"cannot be used: {error}"}


def folder_of(path: str, allow_code: bool = False) -> SweepFolder:
    """Return the sweep in a folder; its list is read again only where it has been changed.

    Raises:
        GpsecError: it cannot be read here.
    """
    with in_a_sentence(f"{path}: cannot be read"):
        info = (Path(path) / LIST).stat()
    return _folder_as_of(path, allow_code, info.st_mtime_ns, info.st_size)


@lru_cache(maxsize=2)
def _folder_as_of(path: str, allow_code: bool, changed_ns: int, size: int) -> SweepFolder:
    return read_folder(Path(path), allow_code=allow_code)


def _made(sweep: SweepFolder, fingerprint: str, tell: "_Teller", run: Run) -> dict[str, Any]:
    if environment_digest() != sweep.environment:
        return {"state": "unfit", "sentence": f"has other code or libraries ({environment_digest()[:12]})"}
    if run is run_as_listed:
        compile_first(sweep, [fingerprint], tell)
    while not sweep.store.has(fingerprint):
        desk = SweepDesk(sweep, [fingerprint], notes=False)
        run_tasks(desk, 1, tell, run)
        if desk.unfit is not None:
            return {"state": "unfit", "sentence": desk.unfit.sentence}
        for failure in desk.failures:
            machine = issubclass(failure.kind, MachineError)
            return {
                "state": "failed",
                "sentence": failure.sentence,
                "details": failure.details,
                "machine": machine,
            }
        if not desk.finished:  # somebody else is at it: another worker that the scheduler has given up
            time.sleep(_LOOK_S)
    return {}


class _Teller:
    """Sends progress to the client, not too often."""

    def __init__(self, worker: Any, path: str) -> None:
        self._worker = worker
        self._path = path
        self._last_s = -_TELL_EVERY_S

    def __call__(self, progress: Progress) -> None:
        if progress.stage in (DONE, FAILED):
            return  # the client says it, once it counts
        now_s = time.monotonic()
        if progress.note or now_s - self._last_s >= _TELL_EVERY_S:
            self._last_s = now_s
            self._worker.log_event(TOPIC, {"sweep": self._path, "progress": asdict(progress)})
