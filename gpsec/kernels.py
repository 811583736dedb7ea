"""How a loop over rows becomes machine code. numba takes long to import, so the first kernel that is called does it."""

import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, cast

import numpy as np

from gpsec.errors import GpsecError

P = ParamSpec("P")
R = TypeVar("R")

# Layers above those that have kernels: what is in them cannot be compiled into one, since nothing below imports them.
ABOVE = frozenset(
    ["cli", "console", "engine", "opendrive", "paper", "pipeline", "reference", "report", "run", "scenario", "training"]
)
# Where processes that only compile note which kernels are taken; None where kernels are run.
_claims: Path | None = None


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


@cache
def _code_folder() -> Path:
    """Return where machine code is kept, by the content of the package but for the layers above its kernels.

    numba itself looks only at the file of a kernel, not at those of the helpers that are compiled into it.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named)
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for module in sorted(package.rglob("*.py")):
        name = module.relative_to(package)
        if name.parts[0].removesuffix(".py") in ABOVE:
            continue
        digest.update(name.as_posix().encode())
        digest.update(module.read_bytes())
    return cache_folder() / "kernels" / digest.hexdigest()[:16]


class Compiled(Generic[P, R]):
    """A function that becomes machine code when it is first called, by itself or by another one."""

    def __init__(self, function: Callable[P, R], *, keep: bool, allocates: bool = False) -> None:
        update_wrapper(self, function)
        self._function = function
        self._keep = keep
        self._allocates = allocates

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Run the machine code."""
        if _claims is not None and self._keep and self._function.__annotations__.get("return") is None:
            return cast("R", self._compile_for(args, _claims))
        return cast("R", self.dispatcher(*args, **kwargs))

    def _compile_for(self, args: tuple[Any, ...], claims: Path) -> None:
        """Compile the function for such arguments unless another process does, and set all flags in them."""
        types = tuple(self.dispatcher.typeof_pyval(argument) for argument in args)
        for flags in _flags(args):
            flags[...] = True
        name = f"{self._function.__module__}.{self._function.__qualname__}{types}"
        try:
            (claims / hashlib.sha256(name.encode()).hexdigest()).touch(exist_ok=False)
        except FileExistsError:
            return
        self.dispatcher.compile(types)

    @cached_property
    def dispatcher(self) -> Any:
        """What numba makes of the function for Python to call."""
        return _numba().njit(cache=self._keep, no_cfunc_wrapper=True, **self._options)(self._function)

    @cached_property
    def part(self) -> Any:
        """What numba makes of it for other functions to call: without the way in from Python, which costs as much."""
        return _numba().njit(no_cfunc_wrapper=True, no_cpython_wrapper=True, **self._options)(self._function)

    @property
    def _options(self) -> dict[str, Any]:
        # Without numba's run time (NRT), code neither allocates nor counts references to arrays. The counts of the some
        # forty arrays of a map, taken again at each branch of a search, made matching three times as slow.
        return {"nogil": True, "error_model": "numpy", "_nrt": self._allocates}


def _flags(values: Iterable[Any]) -> Iterator[np.ndarray]:
    """Yield the arrays of flags among `values` and in the tuples among them."""
    for value in values:
        if isinstance(value, tuple):
            yield from _flags(value)
        elif isinstance(value, np.ndarray) and value.dtype == np.bool_ and value.flags.writeable:
            yield value


@cache
def _numba() -> Any:
    """Return numba, told where to keep machine code and that a `Compiled` is code of its own."""
    import numba
    from numba.core import event, types
    from numba.extending import typeof_impl

    numba.config.CACHE_DIR = str(_code_folder())
    typeof_impl.register(Compiled)(lambda function, context: types.Dispatcher(function.part))
    event.register("numba:compile", _compiling())
    return numba


@cache
def _compiling() -> Any:
    from numba.core import event

    return event.TimingListener()


def only_compile(claims: Path) -> None:
    """From now on, let calls of kernels compile them and no more, each in one of the processes that share `claims`.

    What a kernel would fill keeps its values, but flags are set, so that whatever depends on one of them is called as
    well. Kernels that return something do run, since their callers go on with it.
    """
    global _claims
    _claims = claims


def load() -> None:
    """Import numba, which the first kernel would do, while there is something to wait for."""
    _numba()


def are_compiled() -> bool:
    """Return whether machine code of this version is kept already."""
    folder = _code_folder()
    return folder.is_dir() and any(folder.rglob("*.nbi"))


def compile_seconds() -> float:
    """Return the wall-clock seconds that this process has spent in compiling kernels so far."""
    if "numba" not in sys.modules:
        return 0.0
    listener = _compiling()
    return float(listener.duration) if listener.done else 0.0


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first use and keep the machine code for later runs.

    Kernels release the GIL, so that `gpsec.threads` can run them on disjoint rows at once, and never use
    fast-math: the same input gives the same bits whatever the batch. They cannot allocate: the caller hands them the
    arrays that they fill and those that they need to work in.
    """
    return Compiled(function, keep=True)


def allocating_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` like a kernel that may make arrays; it is slower where many arrays are passed around."""
    return Compiled(function, keep=True, allocates=True)


def inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small helper that kernels call and the optimiser inlines; its code is kept with theirs."""
    return Compiled(function, keep=False)
