"""Hidden folders beside outputs, for files in the making; they keep two runs from one output."""

import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.system import refusal
from gpsec.running.folders import resolved
from gpsec.running.publishing import finish, is_finished

LOCK = ".lock"
_TRIES = 100
_LOOKS, _LOOK_S = 3, 0.01


class Workshop:
    """A hidden folder beside an output, on the same file system, for files in the making.

    Attributes:
        folder: of the files.
        kept: it stays after the run, to go on with.
        left: names of the scenarios that a run that stopped has left in it.
        brought_to_its_end: a run was killed while it took its place in the output, which is whole now.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.kept = folder.exists()  # until something is begun in it
        self.left = _scenarios(folder)
        self.brought_to_its_end = False

    def begin(self, *, resume: bool) -> None:
        """Throw away what a run that was killed has left, or with `resume` all but its scenarios."""
        clear(self.folder, self.left if resume else [])
        self.kept = resume


@contextmanager
def workshops(outs: Sequence[Path]) -> Iterator[dict[Path, Workshop]]:
    """Give a workshop for each of `outs`, and keep other runs from all of them until the end.

    Raises:
        GpsecError: one cannot be made, or another run is at work in it.
    """
    with ExitStack() as stack:
        # In one order for all; who does not get one waits for none, and lets go of those that it has.
        held = {out: stack.enter_context(workshop(out)) for out in sorted(outs)}
        yield {out: held[out] for out in outs}


@contextmanager
def workshop(out: Path) -> Iterator[Workshop]:
    """Give the workshop of `out`; unless it is kept, it is gone afterwards.

    Where a run was killed while it took the place of another one, that is brought to an end first.

    Raises:
        GpsecError: it cannot be made, or another run is at work in it.
    """
    made = [parent for parent in out.parents if not parent.exists()]
    work = Workshop(workshop_of(out))
    try:
        with occupied(work.folder, out):
            try:
                work.brought_to_its_end = not is_finished(out)
                finish(out)
                yield work
            finally:
                if not work.kept:
                    discard(work.folder)
    finally:
        if not work.kept:
            _remove_empty(made)


def settle(out: Path) -> None:
    """Bring to its end what a run that was killed has begun in `out`.

    Raises:
        GpsecError: another run is at work there, or the disk refuses.
    """
    if not is_finished(out):
        with workshop(resolved(out)):
            pass


def workshop_of(out: Path) -> Path:
    """Return where the workshop of an output is.

    Raises:
        GpsecError: there is nothing beside it.
    """
    if not out.name:
        raise GpsecError(f"{out}: expected an output folder, found the root of all folders; choose another --out")
    return out.with_name(f".{out.name[:100]}.partial")


@contextmanager
def occupied(folder: Path, out: Path) -> Iterator[None]:
    """Make a folder for files of `out`, and keep other runs from it.

    Raises:
        GpsecError: it cannot be made, or another run is at work in it.
    """
    for _ in range(_TRIES):
        lock = _locked(folder, out)
        if lock is not None:
            with lock:
                yield
            return
    if not folder.exists():  # as in /proc, where the system says that there is no such folder as the one to be made
        place = next(parent for parent in folder.parents if parent.exists())
        raise GpsecError(f"{out}: no results can be written there: no folder can be made in {place}")
    raise MachineError(f"{out}: no results can be written there: {folder} comes and goes")


def _locked(folder: Path, out: Path) -> TextIOWrapper | None:
    """Return the open lock of a folder, which falls with the process; None where the folder has just been removed."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("w")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise refusal(error, f"{out}: no results can be written there") from None
    with ExitStack() as unless_held:
        unless_held.enter_context(lock)
        try:
            _take(lock)
        except BlockingIOError:
            raise GpsecError(
                f"{out}: another run is being written there; wait for it, or choose another --out"
            ) from None
        except OSError as error:
            raise refusal(error, f"{out}: cannot be locked against other runs") from None
        # Between opening and locking, another run may have ended and taken the folder with it.
        if not _is_at(folder / LOCK, lock):
            return None
        unless_held.pop_all()
    return lock


def _take(lock: TextIOWrapper) -> None:
    for _ in range(_LOOKS):
        with suppress(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        time.sleep(_LOOK_S)  # whoever asks whether it is idle holds it for a moment
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_idle(folder: Path) -> bool:
    """Return whether no run is at work in a workshop that is there."""
    try:
        with (folder / LOCK).open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _is_at(path: Path, lock: TextIOWrapper) -> bool:
    try:
        return os.path.samestat(os.fstat(lock.fileno()), path.stat())
    except OSError:
        return False


def discard(folder: Path) -> None:
    """Remove a folder whose lock we hold; whoever makes it anew meanwhile has one of its own."""
    with suppress(OSError):
        away = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=folder.parent))
        folder.rename(away)
        folder = away
    shutil.rmtree(folder, ignore_errors=True)


def _scenarios(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if not path.name.startswith(".")) if folder.is_dir() else []


def clear(folder: Path, keep: Collection[str] = ()) -> None:
    """Remove what is in a workshop but the folders called `keep`."""
    for path in folder.iterdir():
        if path.name == LOCK or path.name in keep:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def _remove_empty(folders: list[Path]) -> None:
    """Remove what was made for results that did not come, the innermost first."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return  # it holds something, or was not made
