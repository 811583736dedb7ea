"""How a finished run becomes its output folder: whatever happens meanwhile, the former run or the new one is whole.

Where the system can, the two folders change places in one step. Where it cannot (a folder that a disk is mounted on,
or that we stand in; another system), files are moved one by one, in stages that the names of three folders inside the
output tell: what is still being copied is dropped by the next start, what was complete is brought to its end.
"""

import os
import shutil
from contextlib import suppress
from itertools import count
from pathlib import Path

from gpsec.core.disk import copy_attributes, exchange, link_tree, sync, sync_tree
from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.system import refusal
from gpsec.running.folders import check_output, written_by_runs
from gpsec.types.constants import MANIFEST

# The new run while it is copied; complete, while the former one is moved aside; while it is moved to its place.
COPIED, COMPLETE, MOVED = ".gpsec-copied", ".gpsec-complete", ".gpsec-moved"
FORMER = ".gpsec-former"


def publish(made: Path, out: Path, overwrite: bool) -> None:
    """Let the finished folder `made`, which lies in the workshop of `out`, become `out`.

    What no run wrote in it, such as notes, is kept in `out`. Results that cannot be put there are not thrown away:
    they end up in a new folder beside it.

    Raises:
        GpsecError: something has appeared in `out` since it was checked, or it cannot be written.
    """
    try:
        check_output(out, overwrite)
        sync_tree(made)
        _put(made, out)
    except (GpsecError, OSError) as error:
        said = error if isinstance(error, GpsecError) else refusal(error, f"{out}: cannot be written")
        instead = _beside(out)
        try:
            _without_others(made)
            _rename(made, instead)
        except OSError:
            raise said from None
        raise type(said)(f"{said} (the results of this run are in {instead})") from None
    finish(out)


def is_finished(out: Path) -> bool:
    """Return whether no run was killed while it took its place in `out`."""
    return not any(_is_folder(out / name) for name in (COPIED, COMPLETE, MOVED))


def finish(out: Path) -> None:
    """Bring to its end what was begun in `out`, or take it back; only who holds its lock may.

    Raises:
        MachineError: the disk refuses; it can be tried again.
    """
    if is_finished(out):
        return
    copied, complete, moved, former = (out / name for name in (COPIED, COMPLETE, MOVED, FORMER))
    try:
        if _is_folder(copied):
            shutil.rmtree(copied)
        if _is_folder(complete):
            sync(out)
            former.mkdir(exist_ok=True)
            for path in _of_run(out):
                path.rename(former / path.name)
            complete.rename(moved)
        if _is_folder(moved):
            # The manifest comes last: without it a folder holds no run.
            for path in sorted(_of_run(moved), key=lambda path: (path.name == MANIFEST, path.name)):
                path.rename(out / path.name)
            sync(out)
            if _is_folder(former):
                shutil.rmtree(former)
            shutil.rmtree(moved)
    except OSError as error:
        said = refusal(error, f"{out}: cannot be written")
        raise MachineError(f"{said}; the next gpsec run or report there goes on with it") from None


def _put(made: Path, out: Path) -> None:
    """Put a run into its place, or as far that `finish` can."""
    if not out.exists():
        _rename(made, out)
        return
    if not _we_stand_in(out):
        try:
            _change_places(made, out)
        except OSError:
            _without_others(made)
        else:
            return
    _copy_into(made, out)


def _we_stand_in(out: Path) -> bool:
    """Return whether the current folder is `out` or in it: it would be gone from under us."""
    here = Path.cwd()
    return out in (here, *here.parents)


def _change_places(made: Path, out: Path) -> None:
    """Let `made` have all that no run wrote in `out` too, and change places with it.

    Raises:
        OSError: that cannot be; `out` is as it was.
    """
    for path in _others(out):
        link_tree(path, made / path.name)
    copy_attributes(out, made)
    os.utime(made)
    sync(made)
    exchange(made, out)
    with suppress(OSError):  # what is left of the former run goes with the workshop
        sync(out.parent)
        _take_late(made, out)
        shutil.rmtree(made)


def _take_late(former: Path, out: Path) -> None:
    """Move to `out` what somebody has written into the former folder since it was looked at."""
    for path in _others(former):
        for written in _files(path):
            there = out / written.relative_to(former)
            if not (os.path.lexists(there) and os.path.samestat(written.lstat(), there.lstat())):
                there.parent.mkdir(parents=True, exist_ok=True)
                written.replace(there)


def _files(path: Path) -> list[Path]:
    return [each for each in path.rglob("*") if not _is_folder(each)] if _is_folder(path) else [path]


def _copy_into(made: Path, out: Path) -> None:
    """Copy a run into `out`, from where `finish` can move it to its place."""
    copied = out / COPIED
    copied.mkdir()
    try:
        for path in _of_run(made):
            shutil.copy2(path, copied / path.name)
        sync_tree(copied)
        copied.rename(out / COMPLETE)  # from here on there is no way back
    except OSError:
        shutil.rmtree(copied, ignore_errors=True)
        raise


def _rename(made: Path, out: Path) -> None:
    made.rename(out)
    sync(out.parent)


def _of_run(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if written_by_runs(path.name)]


def _others(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if not written_by_runs(path.name)]


def _without_others(made: Path) -> None:
    """Remove the links to what no run wrote."""
    for path in _others(made):
        if _is_folder(path):
            shutil.rmtree(path)
        else:
            path.unlink()


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _beside(out: Path) -> Path:
    return next(path for number in count(2) if not (path := out.with_name(f"{out.name}-{number}")).exists())
