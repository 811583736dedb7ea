"""What runs and commands that were killed have left behind."""

import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.running.workshop import LOCK, Workshop, discard, is_idle, occupied

# Of a run; of one that was being removed, or of a scenario in the making; of the commands that make traffic and nets.
_WORKSHOP = re.compile(r"\..+\.partial")
_REMOVED = re.compile(r"\..+\.partial-\w{8}")
_MADE = re.compile(r"\.gpsec-(demand|import)-\w{8}")
_TEMPORARY = re.compile(r"gpsec-(sumo|again|train)-\w{8}")
# Whatever has no lock may be at work still, unless nobody has touched it for a day.
_DAY_S = 86_400.0


@dataclass(frozen=True)
class Leftover:
    """A file or folder that nobody needs any more.

    Attributes:
        path: where it is.
        what: it is, for the user.
    """

    path: Path
    what: str

    @property
    def size(self) -> int:
        """Bytes of its files, as far as they can be seen."""
        return sum(_size(path) for path in (self.path, *self.path.rglob("*")))

    def remove(self) -> None:
        """Remove it.

        Raises:
            GpsecError: a run is at work in it, or it cannot be removed.
        """
        if _WORKSHOP.fullmatch(self.path.name):
            with occupied(self.path, self.path):
                discard(self.path)
        else:
            _remove(self.path)


def leftovers(folder: Path) -> list[Leftover]:
    """Return what is left behind in a folder, in which outputs, scenarios or nets lie or may have been made.

    Raises:
        GpsecError: it cannot be read.
    """
    with in_a_sentence(f"{folder}: cannot be read"):
        return sorted(_found(folder), key=lambda left: left.path)


def temporary() -> list[Leftover]:
    """Return what is left behind where the system keeps temporary files."""
    with in_a_sentence("temporary files cannot be read"):
        folder = Path(tempfile.gettempdir())
        what = "temporary files of a command that was killed"
        return sorted(
            (
                Leftover(path, what)
                for path in folder.iterdir()
                if _TEMPORARY.fullmatch(path.name) and _is_ours(path) and _is_old(path)
            ),
            key=lambda left: left.path,
        )


def found_at_start(works: Mapping[Path, Workshop], *, resume: bool) -> str:
    """Say in one line what runs that stopped have left, and what becomes of it; empty where there is nothing.

    `works` are the workshops of the outputs that are written.
    """
    becomes = "to go on with" if resume else "thrown away (--resume would have gone on)"
    said = [f"{out} half replaced, which is whole now" for out, work in works.items() if work.brought_to_its_end]
    said += [f"{', '.join(work.left)} in {work.folder}, {becomes}" for work in works.values() if work.left]
    ours = {work.folder for work in works.values()}
    with suppress(GpsecError):  # a folder may be one to write in, and not to read
        beside = [left.path for folder in dict.fromkeys(out.parent for out in works) for left in leftovers(folder)]
        if others := [path for path in beside if path not in ours]:
            said.append(f"{others[0]} and {len(others) - 1} more of other runs (gpsec clean)")
    return "; ".join(said)


def _found(folder: Path) -> Iterator[Leftover]:
    for path in folder.iterdir():
        if path.is_symlink() or not path.is_dir():
            continue
        if _WORKSHOP.fullmatch(path.name) and (path / LOCK).is_file():
            if is_idle(path):
                yield Leftover(path, "of a run that stopped; gpsec run --resume would go on with it")
        elif (_REMOVED.fullmatch(path.name) or _MADE.fullmatch(path.name)) and _is_old(path):
            yield Leftover(path, "of a command that was killed")


def _is_old(path: Path) -> bool:
    return time.time() - path.lstat().st_mtime > _DAY_S


def _is_ours(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink() and path.stat().st_uid == os.geteuid()


def _size(path: Path) -> int:
    try:
        return path.lstat().st_size
    except OSError:
        return 0


def _remove(path: Path) -> None:
    with in_a_sentence(f"{path}: cannot be removed"):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
