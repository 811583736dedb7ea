"""Where gpsec keeps what it can compute again, whom it trusts there, and how it knows that an entry is whole.

A digest beside an entry tells damage. It cannot tell malice, since whoever can change the one can change the other:
hence the look at who owns and may write the folder.
"""

import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from uuid import uuid4

from gpsec.core import sources
from gpsec.core.errors import GpsecError, shown
from gpsec.core.trust import is_ours, refuse_shared

_DIGESTS = "SHA256SUMS"
_DIGEST_BYTES = 32
# Names of what is kept: by the code it was made with, and with what, or on what machine; of Plotly's script; of what is
# being written; and names that an earlier version gave.
_MADE = re.compile(r"(?P<kind>[\w.]+)-(?P<code>[0-9a-f]{16})(-[0-9a-f]{16,32})?")
_PACK = re.compile(r"plotly-([0-9a-f]{16}|[\w.]+\.packed)")
_PARTIAL = re.compile(r"\.gpsec-[0-9a-f]{12}")
_FORMER = re.compile(r"[0-9a-f]{16}|[0-9a-f]{32}")


def cache_folder() -> Path:
    """Return where everything is kept: ``$GPSEC_CACHE``, or ``~/.cache/gpsec``; it may be one for reading only.

    Raises:
        GpsecError: there is none and none can be made, or somebody else can change what is in it.
    """
    named = os.environ.get("GPSEC_CACHE")
    where = f"GPSEC_CACHE={shown(named)}" if named else "~/.cache/gpsec"
    try:
        folder = Path(named) if named else Path.home() / ".cache" / "gpsec"
    except RuntimeError:  # a user without a home
        folder = None
    return _usable(folder, where, "GPSEC_CACHE")


def kernels_folder() -> Path:
    """Return where machine code is kept: in ``$NUMBA_CACHE_DIR`` where that is set.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    if not named:
        return _below(cache_folder(), "kernels", variable="GPSEC_CACHE")
    return _usable(Path(named) / "gpsec", f"NUMBA_CACHE_DIR={shown(named)}", "NUMBA_CACHE_DIR")


def kernel_folder(owner: str) -> Path | None:
    """Return where the machine code of a layer (`sources.owner`) is kept, by what it can depend on; None: nowhere.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    name = _kernels_now(owner)
    return None if name is None else _in_kernels(name)


def warmup_file(machine: str) -> Path:
    """Return where it is noted what a warm-up on such a machine has compiled of the code of this version.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    return _in_kernels(f"{_warmup_now()}-{hashlib.sha256(machine.encode()).hexdigest()[:16]}")


def map_folder(digest: str, root: Path | None = None) -> Path:
    """Return where the map is kept that this code makes of what has that digest; in `root`, or `cache_folder`.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    return _below(root or cache_folder(), "maps", f"{_maps_now()}-{digest[:32]}", variable="GPSEC_CACHE")


def plotly_file() -> Path:
    """Return where Plotly's script is kept, packed for pages.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    return cache_folder() / _versioned("plotly", sources.page_digest(), "plotly")


def stale() -> list[Path]:
    """Return the files and folders in the caches that the gpsec that is installed here will not read again.

    They are of other code, of other versions of libraries, or half written.

    Raises:
        GpsecError: as `cache_folder` does.
    """
    root, kernels = cache_folder(), kernels_folder()
    found = [path for path in _children(root) if _PACK.fullmatch(path.name) and path != plotly_file()]
    for folder in (kernels, root / "maps"):
        found += [path for path in _children(folder) if _is_of_other_code(path.name)]
    within = [root, root / "maps", *(path for path in _children(kernels) if path not in found)]
    found += [path for folder in within for path in _children(folder) if _PARTIAL.fullmatch(path.name)]
    return sorted(found)


def can_keep(folder: Path) -> bool:
    """Return whether a folder, which need not be there yet, can be written."""
    there = next(place for place in (folder, *folder.parents) if place.exists())
    return os.access(there, os.W_OK | os.X_OK, effective_ids=True)


def read(path: Path) -> bytes | None:
    """Return what was written into an entry; None where there is none, it is damaged or it is not ours."""
    try:
        with path.open("rb") as file:
            if not is_ours(file.fileno()):
                return None
            digest, content = file.read(_DIGEST_BYTES), file.read()
    except OSError:
        return None
    return content if hashlib.sha256(content).digest() == digest else None


def write(path: Path, content: bytes) -> None:
    """Make an entry, whole or not at all, with a digest; where it cannot be kept, it is computed again next time."""
    partial = _partial(path.parent)
    with suppress(OSError):
        _make_folder(path.parent)
        try:
            with partial.open("xb") as file:
                os.fchmod(file.fileno(), 0o644)
                file.write(hashlib.sha256(content).digest() + content)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to fill, which takes the place of `folder` with digests once the block has succeeded.

    Raises:
        OSError: it cannot be kept.
    """
    _make_folder(folder.parent)
    partial, damaged = _partial(folder.parent), _partial(folder.parent)
    try:
        partial.mkdir(0o755)
        yield partial
        _seal(partial)
        if folder.exists():
            folder.rename(damaged)
        partial.rename(folder)  # fails where another process was first
    finally:
        for left in (partial, damaged):
            shutil.rmtree(left, ignore_errors=True)


def is_whole(folder: Path) -> bool:
    """Return whether a folder holds the files that were there when it was sealed, unchanged and ours."""
    try:
        lines = (folder / _DIGESTS).read_text("utf-8").splitlines()
        names = {path.name for path in folder.iterdir()} - {_DIGESTS}
        kept = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
        return (
            names == set(kept)
            and is_ours(folder)
            and all(is_ours(folder / name) and _digest(folder / name) == kept[name] for name in names)
        )
    except (OSError, ValueError):
        return False


def _make_folder(folder: Path) -> None:
    """Make a folder and its parents, which nobody else may write, whatever is usual for the user."""
    if not folder.is_dir():
        _make_folder(folder.parent)
        with suppress(FileExistsError):
            folder.mkdir(0o755)


def _partial(folder: Path) -> Path:
    """Return a name for something in the making, which nobody else takes and `stale` lists."""
    return folder / f".gpsec-{uuid4().hex[:12]}"


def _seal(folder: Path) -> None:
    """Write the digests of the files in `folder` beside them, as ``sha256sum`` does."""
    lines = [f"{_digest(path)}  {path.name}\n" for path in sorted(folder.iterdir())]
    (folder / _DIGESTS).write_text("".join(lines), "utf-8")
    for path in folder.iterdir():
        path.chmod(0o644)
    folder.chmod(0o755)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@cache
def _versioned(name: str, digest: str, *packages: str) -> str:
    versions = " ".join(f"{package} {version(package)}" for package in packages)
    return f"{name}-{hashlib.sha256(f'{digest} {versions}'.encode()).hexdigest()[:16]}"


def _kernels_now(owner: str) -> str | None:
    digest = sources.digest(owner)
    return None if digest is None else _versioned(owner, digest, "numba")


def _maps_now() -> str:
    return _versioned("map", str(sources.digest("gpsec.hdmap")), "numpy", "shapely")


def _warmup_now() -> str:
    layers = sorted(f"gpsec.{name}" for name in sources.STAGES)
    return _versioned("warmup", " ".join(str(sources.digest(layer)) for layer in layers), "numba")


def _is_of_other_code(name: str) -> bool:
    """Return whether an entry is named as one of ours, but not as one of the code that is here."""
    if _FORMER.fullmatch(name):
        return True
    made = _MADE.fullmatch(name)
    if made is None:
        return False  # somebody else's
    kind = made["kind"]
    now = _maps_now() if kind == "map" else _warmup_now() if kind == "warmup" else _kernels_now(kind)
    return now != f"{kind}-{made['code']}"


def _children(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _in_kernels(name: str) -> Path:
    variable = "NUMBA_CACHE_DIR" if os.environ.get("NUMBA_CACHE_DIR") else "GPSEC_CACHE"
    return _below(kernels_folder(), name, variable=variable)


def _below(folder: Path, *names: str, variable: str) -> Path:
    """Return a folder in one that is trusted; it need not exist, but nobody else may have made it."""
    for name in names:
        folder = folder / name
        if folder.exists():
            folder = folder.resolve()
            refuse_shared(folder, str(folder), variable)
    return folder


def _usable(folder: Path | None, where: str, variable: str) -> Path:
    """Return a folder as it is without links, made where it is not there yet."""
    try:
        if folder is None:
            raise NotADirectoryError
        _make_folder(folder.absolute())
        folder = folder.resolve(strict=True)
        usable = folder.is_dir() and os.access(folder, os.R_OK | os.X_OK, effective_ids=True)
    except OSError:
        usable = False
    if folder is None or not usable:
        raise GpsecError(f"{where}: expected a folder that can be written; name another one in {variable}")
    refuse_shared(folder, where, variable)
    return folder
