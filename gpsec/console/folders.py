"""Output folders: nothing half-written ever stands under the final name."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gpsec.errors import GpsecError

MANIFEST = "manifest.json"
_WRITTEN_BY_RUNS = {".csv", ".json", ".parquet", ".html"}


def check_output(out: Path, overwrite: bool) -> None:
    """Check that a run may be written to `out`.

    Raises:
        GpsecError: it is a file, or it holds something that would be lost.
    """
    if out.is_symlink() and not out.exists():
        raise GpsecError(f"{out}: expected an output folder, found a link that leads nowhere")
    if out.exists() and not out.is_dir():
        raise GpsecError(f"{out}: expected an output folder, found a file")
    if not out.exists() or not any(out.iterdir()):
        return
    if not (out / MANIFEST).is_file():
        raise GpsecError(f"{out}: expected an empty or new folder, found files that no run wrote; choose another --out")
    if not overwrite:
        raise GpsecError(f"{out}: holds another run; give --overwrite to replace it, or choose another --out")


@contextmanager
def workshop(out: Path) -> Iterator[Path]:
    """Give a new folder beside `out`, on the same file system, for files in the making; it is gone afterwards.

    Raises:
        GpsecError: it cannot be made.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=f".{out.name}.partial-", dir=out.parent))
    except OSError as error:
        raise GpsecError(f"{out}: no results can be written there: {error.strerror}") from None
    try:
        yield work
    finally:
        shutil.rmtree(work, ignore_errors=True)


def publish(made: Path, out: Path, former: Path, overwrite: bool) -> None:
    """Let the finished folder `made` become `out`; a run that it replaces is moved to `former`.

    What no run wrote in it, such as notes, is kept in `out`.

    Raises:
        GpsecError: something has appeared in `out` since it was checked.
    """
    check_output(out, overwrite)
    made.chmod(0o755)
    if out.exists() and any(out.iterdir()):
        out.rename(former)
        made.rename(out)
        for kept in former.iterdir():
            if kept.is_dir() or kept.suffix not in _WRITTEN_BY_RUNS:
                kept.rename(out / kept.name)
    else:
        made.rename(out)
