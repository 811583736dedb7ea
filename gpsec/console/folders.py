"""Output folders: nothing half-written ever stands under the final name."""

import fcntl
import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from gpsec.errors import GpsecError, shown

MANIFEST = "manifest.json"
_LOCK = ".lock"
REPORT = "report.html"
_TABLES = ("detection", "localization", "safety", "events", "vehicles", "curves", "error_bands", "places")
_AS_PARQUET = ("events.parquet", "vehicles.parquet", "places.parquet")
_WRITTEN_BY_RUNS = (MANIFEST, REPORT, *(f"{table}.csv" for table in _TABLES), *_AS_PARQUET)
# What each scenario has one of, under a name of its own where a run has several.
_ONE_EACH = ("steps.parquet", "steps-*.parquet", "map.geojson", "map-*.geojson")
# What other commands made of a run goes with it.
_MADE_OF_RUNS = ("comparison.html", "places.geojson", "trace-*.html")


def check_output(out: Path, overwrite: bool) -> None:
    """Check that a run may be written to `out`.

    Raises:
        GpsecError: it is a file, or it holds something that would be lost.
    """
    try:
        there, holds_nothing = out.exists(), not out.is_dir() or not any(out.iterdir())
    except OSError as error:
        raise GpsecError(f"{shown(out)}: no results can be written there: {error.strerror}") from None
    if out.is_symlink() and not there:
        raise GpsecError(f"{out}: expected an output folder, found a link that leads nowhere")
    if there and not out.is_dir():
        raise GpsecError(f"{out}: expected an output folder, found a file")
    if holds_nothing:
        return
    # A run that was killed while it took its place has no manifest yet.
    if not any((out / name).is_file() for name in _WRITTEN_BY_RUNS):
        raise GpsecError(f"{out}: expected an empty or new folder, found files that no run wrote; choose another --out")
    if not overwrite:
        raise GpsecError(f"{out}: holds another run; give --overwrite to replace it, or choose another --out")


class Workshop:
    """A hidden folder beside an output, on the same file system, for files in the making.

    Attributes:
        folder: of the files.
        kept: it is there to go on with after the run, since that is not complete.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.kept = False


@contextmanager
def workshop(out: Path, *, resume: bool) -> Iterator[Workshop]:
    """Give the workshop of `out`; unless it is kept, it is gone afterwards.

    What a run that was killed has left in it is thrown away, or with `resume` found there.

    Raises:
        GpsecError: it cannot be made, or another run is at work in it.
    """
    made = [parent for parent in out.parents if not parent.exists()]
    work = Workshop(out.with_name(f".{out.name[:100]}.partial"))
    try:
        with occupied(work.folder, out):
            if not resume:
                clear(work.folder)
            try:
                yield work
            finally:
                if not work.kept:
                    shutil.rmtree(work.folder, ignore_errors=True)
    finally:
        if not work.kept:
            _remove_empty(made)


@contextmanager
def occupied(folder: Path, out: Path) -> Iterator[None]:
    """Make a folder for files of `out`, and keep other runs from it.

    Raises:
        GpsecError: it cannot be made, or another run is at work in it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / _LOCK).open("w")
    except OSError as error:
        raise GpsecError(f"{out}: no results can be written there: {error.strerror}") from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # it falls with the process that holds it
        except OSError:
            raise GpsecError(
                f"{out}: another run is being written there; wait for it, or choose another --out"
            ) from None
        yield


def clear(folder: Path, keep: Collection[str] = ()) -> None:
    """Remove what is in a workshop but the folders called `keep`."""
    for path in folder.iterdir():
        if path.name == _LOCK or path.name in keep:
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


def resolved(out: Path) -> Path:
    """Return `out` as an absolute path without links.

    Raises:
        GpsecError: links lead in a circle, or the current folder is gone.
    """
    try:
        return out.resolve()
    except (OSError, RuntimeError) as error:
        said = getattr(error, "strerror", None) or str(error)
        raise GpsecError(f"{out}: no results can be written there: {said}") from None


def publish(made: Path, out: Path, former: Path, overwrite: bool) -> None:
    """Let the finished folder `made` become `out`; a run that it replaces is moved to `former`.

    What no run wrote in it, such as notes, is kept in `out`. Results that cannot be put there are not thrown away:
    they end up in a new folder beside it.

    Raises:
        GpsecError: something has appeared in `out` since it was checked, or it cannot be written.
    """
    try:
        check_output(out, overwrite)
        _put(made, out, former)
    except (GpsecError, OSError) as error:
        said = str(error) if isinstance(error, GpsecError) else f"{out}: cannot be written: {error.strerror}"
        instead = _beside(out)
        try:
            _put(made, instead, former)
        except OSError:
            raise GpsecError(said) from None
        raise GpsecError(f"{said} (the results of this run are in {instead})") from None


def _put(made: Path, out: Path, former: Path) -> None:
    if not out.exists():
        if made.stat().st_dev != out.parent.stat().st_dev:
            near = Path(tempfile.mkdtemp(prefix=f".{out.name[:100]}.partial-", dir=out.parent))
            made = Path(shutil.copytree(made, near, dirs_exist_ok=True))
        made.chmod(0o755)
        made.rename(out)
        return
    # The folder stays what it is: somebody may stand in it, or it is where a disk is mounted.
    former.mkdir()
    each = [path.name for pattern in (*_ONE_EACH, *_MADE_OF_RUNS) for path in out.glob(pattern)]
    for name in (*_WRITTEN_BY_RUNS, *each):
        if (out / name).exists():
            shutil.move(out / name, former / name)
    # The manifest comes last: without it a folder holds no run.
    for path in sorted(made.iterdir(), key=lambda path: (path.name == MANIFEST, path.name)):
        shutil.move(path, out / path.name)


def _beside(out: Path) -> Path:
    return next(path for number in count(2) if not (path := out.with_name(f"{out.name}-{number}")).exists())
