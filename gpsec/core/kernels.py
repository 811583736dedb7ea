"""How a loop over rows becomes machine code. numba takes long to import, so the first kernel that is called does it.

A loop that is the same for a family of functions is written once, in a function that makes a kernel of some of them:

    @cache
    def moving(predict: Callable[..., None]) -> Callable[..., None]:
        @kernel
        def move(rows: Ints, ...) -> None:
            for row in rows:
                predict(...)

        return move

What a kernel closes over are compiled functions and numbers. Its machine code is kept under the names of all of them,
and is compiled anew when the sources of one change, whoever owns them.
"""

import hashlib
import json
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property, partial, update_wrapper
from importlib.metadata import version
from inspect import getclosurevars, ismodule
from pathlib import Path
from secrets import randbits
from typing import Any, Generic, ParamSpec, TypeVar, cast

import numpy as np

from gpsec.core import caches, sources

P = ParamSpec("P")
R = TypeVar("R")

# What Linux says of a processor that LLVM goes by, on x86 and on ARM; the rest changes from one moment to the next.
_PROCESSOR = re.compile(r"(vendor_id|cpu family|model|model name|stepping|flags|Features|CPU \w+)\s*:")
# Where processes that only compile note which kernels are taken; None where kernels are run.
_claims: Path | None = None


class Compiled(Generic[P, R]):
    """A function that becomes machine code when it is first called, by itself or by another one."""

    def __init__(
        self, function: Callable[P, R], *, keep: bool, allocates: bool = False, dissolves: bool = False
    ) -> None:
        update_wrapper(self, function)
        self._function = function
        self._keep = keep
        self._allocates = allocates
        self._dissolves = dissolves
        sources.notice(sources.owner(function.__module__))

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
        name = f"{self.identity}{types}"
        try:
            (claims / hashlib.sha256(name.encode()).hexdigest()).touch(exist_ok=False)
        except FileExistsError:
            return
        self.dispatcher.compile(types)

    @cached_property
    def dispatcher(self) -> Any:
        """What numba makes of the function for Python to call."""
        made = _numba().njit(no_cfunc_wrapper=True, **self._options)(self._function)
        if self._keep and not _numba().config.DISABLE_JIT:
            from gpsec.core.machinecode import keep

            keep(made, self.identity, self._owners())
        return made

    @cached_property
    def identity(self) -> str:
        """What tells the function from all others: its name and place, and those of what it closes over."""
        code = self._function.__code__
        closed = "".join(f"({_identity(value)})" for value in self._closed_over())
        return f"{self._function.__module__}.{self._function.__qualname__}:{code.co_firstlineno}{closed}"

    def _closed_over(self) -> list[Any]:
        return [cell.cell_contents for cell in self._function.__closure__ or ()]

    def _owners(self) -> list[str]:
        """Return what owns the function, and then the others that own what is compiled into it."""
        found: list[Compiled[..., Any]] = [self]
        for compiled in found:  # which grows
            found += [value for value in compiled._called() if value not in found]
        own, *others = dict.fromkeys(sources.owner(compiled._function.__module__) for compiled in found)
        covered = {f"gpsec.{name}" for name in sources.covered(own)}
        return [own, *sorted(owner for owner in others if owner not in covered)]

    def _called(self) -> list["Compiled[..., Any]"]:
        """Return the compiled functions that this one may call, but those of gpsec's that its layer covers."""
        values = self._closed_over()
        if not self._function.__module__.startswith("gpsec."):
            names = list(getclosurevars(self._function).globals.values())
            attributes = self._function.__code__.co_names
            values += names
            values += [vars(value).get(name) for value in names if ismodule(value) for name in attributes]
        return [value for value in values if isinstance(value, Compiled)]

    @cached_property
    def part(self) -> Any:
        """What numba makes of it for other functions to call: without the way in from Python, which costs as much."""
        options = {"no_cpython_wrapper": True, "forceinline": self._dissolves, **self._options}
        return _numba().njit(no_cfunc_wrapper=True, **options)(self._function)

    @property
    def _options(self) -> dict[str, Any]:
        # Without numba's run time (NRT), code neither allocates nor counts references to arrays. The counts of the some
        # forty arrays of a map, taken again at each branch of a search, made matching three times as slow.
        return {"nogil": True, "error_model": "numpy", "_nrt": self._allocates}


def _identity(value: Any) -> str:
    if isinstance(value, Compiled):
        return value.identity
    from numba.core.serialize import dumps

    return hashlib.sha256(dumps(value)).hexdigest()


def _flags(values: Iterable[Any]) -> Iterator[np.ndarray]:
    """Yield the arrays of flags among `values` and in the tuples among them."""
    for value in values:
        if isinstance(value, tuple):
            yield from _flags(value)
        elif isinstance(value, np.ndarray) and value.dtype == np.bool_ and value.flags.writeable:
            yield value


@cache
def _numba() -> Any:
    """Return numba, told that a `Compiled` is code of its own, and to number symbols at random.

    numba numbers the symbols of each process from one. Where kept code of several processes met in another, kernels
    that were made alike had helpers of one symbol, and the linker gave all of them the first (numba issue 10486).
    """
    import numba
    from numba.core import event, types
    from numba.core.bytecode import FunctionIdentity
    from numba.extending import typeof_impl

    FunctionIdentity._unique_ids = iter(partial(randbits, 62), -1)
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


def import_compiler() -> None:
    """Import numba, which the first kernel would do, while there is something to wait for."""
    _numba()


def are_compiled() -> bool:
    """Return whether all that a warm-up has compiled of this code, for this machine, is kept and will be loaded.

    Raises:
        GpsecError: there is no cache, or it is not safe.
    """
    noted = caches.read(caches.warmup_file(_machine()))
    if noted is None:
        return False
    folder = caches.kernels_folder()
    return all(caches.read(folder / name) is not None for name in json.loads(noted))


def kept() -> list[str]:
    """Return what this process has written or read of machine code, for `note_warmup`."""
    if "gpsec.core.machinecode" not in sys.modules:
        return []
    from gpsec.core.machinecode import entries

    return sorted(path.relative_to(caches.kernels_folder()).as_posix() for path in entries)


def note_warmup(names: Iterable[str]) -> None:
    """Note what all processes of a warm-up have `kept`, for `are_compiled`."""
    caches.write(caches.warmup_file(_machine()), json.dumps(sorted(set(names))).encode())


@cache
def _machine() -> str:
    """Return what decides whether numba loads kept code: Python and the processor; asking LLVM would take long."""
    told = [os.environ.get(name, "") for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")]
    listed = Path("/proc/cpuinfo")
    first = listed.read_text("utf-8").partition("\n\n")[0] if listed.exists() else platform.processor()
    lines = [line for line in first.splitlines() if _PROCESSOR.match(line)] or [first]
    return "\n".join([str(sys.implementation.cache_tag), version("llvmlite"), platform.machine(), *told, *lines])


def compile_seconds() -> float:
    """Return the wall-clock seconds that this process has spent in compiling kernels so far."""
    if "numba" not in sys.modules:
        return 0.0
    listener = _compiling()
    return float(listener.duration) if listener.done else 0.0


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first use and keep the machine code for later runs.

    Kernels release the GIL, so that `gpsec.core.threads` can run them on disjoint rows at once, and never use
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


def always_inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a helper that dissolves in the kernel whatever its size, so that it may take whole structures.

    A call that is left costs as much as a helper does, where structures of some twenty arrays are handed over. For
    functions that a kernel is made of and calls in one place.
    """
    return Compiled(function, keep=False, dissolves=True)
