"""`gpsec clean`: lists what is left behind and what caches hold of other versions, and removes it."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import complain, say
from gpsec.core.caches import stale
from gpsec.core.errors import GpsecError
from gpsec.running.leftovers import Leftover, leftovers, temporary


def clean(
    folders: Annotated[
        list[Path] | None, typer.Argument(metavar="[DIR]...", help="Where to look. [default: here and in results]")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Remove it without asking.")] = False,
) -> int:
    """List what runs that were killed have left, and what caches hold of other versions; remove it if you say so.

    \b
    Examples:
      gpsec clean
      gpsec clean results/studies --yes
    """  # noqa: D301
    return _clean(folders or [folder for folder in (Path(), Path("results")) if folder.is_dir()], yes=yes)


def _clean(folders: Sequence[Path], *, yes: bool) -> int:
    """List what can go from `folders`, temporary files and caches; remove it with `yes`, or if the user says so.

    Return the exit status.

    Raises:
        GpsecError: a folder cannot be read, or the caches are not to be trusted.
    """
    found = [left for folder in dict.fromkeys(folders) for left in leftovers(folder)]
    found += temporary()
    found += [Leftover(path, "made by another version of gpsec, its libraries or its code") for path in stale()]
    if not found:
        say("nothing is left behind")
        return 0
    sizes = [left.size for left in found]
    for left, size in zip(found, sizes, strict=True):
        say(f"{left.path}: {_readable(size)}, {left.what}")
    if not (yes or _agreed(f"remove {_counted(len(found))}, {_readable(sum(sizes))}?")):
        return 0
    return _remove(found)


def _agreed(question: str) -> bool:
    if not sys.stdin.isatty():
        say("nothing has been removed; --yes does it")
        return False
    return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")


def _remove(found: Sequence[Leftover]) -> int:
    statuses = []
    for left in found:
        try:
            left.remove()
        except GpsecError as error:
            statuses.append(complain(error))
    say(f"removed {_counted(len(found) - len(statuses))}")
    return min(statuses, default=0)


def _counted(number: int) -> str:
    return "1 of them" if number == 1 else f"{number} of them"


def _readable(size: int) -> str:
    """Return a number of bytes as one reads it; what is there is never 0."""
    for unit, name in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if size >= unit:
            return f"{size / unit:.1f} {name}"
    return f"{size} bytes"
