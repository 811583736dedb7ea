"""How a loop over rows becomes machine code."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba
from numba.core import event

from gpsec.errors import GpsecError

P = ParamSpec("P")
R = TypeVar("R")


def cache_folder() -> Path:
    """Return where gpsec keeps what it can compute again: ``$GPSEC_CACHE``, or ``~/.cache/gpsec``."""
    named = os.environ.get("GPSEC_CACHE")
    try:
        folder = Path(named) if named else Path.home() / ".cache" / "gpsec"
        folder.mkdir(parents=True, exist_ok=True)
        usable = os.access(folder, os.W_OK | os.X_OK)
    except (OSError, RuntimeError):  # no folder, or a user without a home
        usable = False
    if not usable:
        where = f"GPSEC_CACHE={named}" if named else "~/.cache/gpsec"
        raise GpsecError(f"{where}: expected a folder that can be written; name another one in GPSEC_CACHE")
    return folder.absolute()


def _code_folder() -> str:
    """Return where machine code is kept, by the content of the package.

    numba itself looks only at the file of a kernel, not at those of the helpers that are compiled into it.
    """
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for module in sorted(package.rglob("*.py")):
        digest.update(module.relative_to(package).as_posix().encode())
        digest.update(module.read_bytes())
    return str(cache_folder() / "kernels" / digest.hexdigest()[:16])


if not numba.config.CACHE_DIR:
    numba.config.CACHE_DIR = _code_folder()


_compiling = event.TimingListener()
event.register("numba:compile", _compiling)


def are_compiled() -> bool:
    """Return whether machine code of this version is kept already."""
    folder = Path(numba.config.CACHE_DIR)
    return folder.is_dir() and any(folder.rglob("*.nbi"))


def compile_seconds() -> float:
    """Return the wall-clock seconds that this process has spent in compiling kernels so far."""
    return float(_compiling.duration) if _compiling.done else 0.0


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first use and keep the machine code for later runs.

    Kernels release the GIL, so that `gpsec.threads` can run them on disjoint rows at once, and never use
    fast-math: the same input gives the same bits whatever the batch.
    """
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small helper that kernels call and the optimiser inlines; its code is kept with theirs."""
    return cast("Callable[P, R]", numba.njit(nogil=True, error_model="numpy")(function))
