"""How machine code is kept: by what it was made of, with a digest.

numba's own cache goes by the path of a kernel's file, which every install has another of, looks at no other file, and
reads pickles unchecked.
"""

import hashlib
import pickle
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching
from numba.core.serialize import dumps
from numba.core.types.containers import BaseTuple

from gpsec.core import caches, sources

# The entries that this process has written or read, whatever the kernel.
entries: set[Path] = set()


def keep(dispatcher: Any, identity: str, owners: Sequence[str]) -> None:
    """Let what `dispatcher` compiles be kept, where its sources can be found.

    `identity` tells the function from others, whatever they close over. The first of the owners (`sources.owner`) is
    that of the function, the others those of what is compiled into it.
    """
    folder, stamps = _folder(owners[0]), [sources.digest(owner) for owner in owners]
    if folder is not None and all(stamps):
        stamp = " ".join([identity, *map(str, stamps)])
        dispatcher._cache = _Cache(dispatcher, _Locator(dispatcher.py_func, folder, stamp), owners)


@cache
def _folder(owner: str) -> Path | None:
    return caches.kernel_folder(owner)


class _Locator(caching._CacheLocator):  # type: ignore[misc]
    """Says where the code of a function is kept, and of which sources it is."""

    def __init__(self, function: Any, folder: Path, stamp: str) -> None:
        self._py_file, self._lineno = function.__code__.co_filename, function.__code__.co_firstlineno
        self._module, self._folder, self._stamp = function.__module__, folder, stamp

    def ensure_cache_path(self) -> None:
        """Leave it to whoever writes."""

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return the name of the function, and the digest of all sources that the code can depend on."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Tell functions of one name apart that are in different modules or places of a module."""
        return f"{hashlib.sha256(self._module.encode()).hexdigest()[:8]}-{self._lineno}"


class _Results(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Turns results of compiling into what can be written, as numba does it."""

    def __init__(self, function: Any, locator: _Locator) -> None:
        self._lineno, self._locator = function.__code__.co_firstlineno, locator
        self._filename_base = self.get_filename_base(f"{function.__module__}.{function.__qualname__}", sys.abiflags)


class _Files:
    """One file for each function, types of arguments and processor, in place of numba's index and what it lists."""

    def __init__(self, folder: Path, base: str) -> None:
        self._folder, self._base = folder, base

    def load(self, key: tuple[Any, ...]) -> Any:
        """Return what was saved, None where there is nothing that is whole."""
        path = self._path(key)
        content = caches.read(path)
        if content is None:
            return None
        found, data = pickle.loads(content)  # whole, and from a folder that nobody else can write
        if found != key:
            return None
        entries.add(path)
        return data

    def save(self, key: tuple[Any, ...], data: Any) -> None:
        """Write an entry; one that is there is replaced."""
        path = self._path(key)
        caches.write(path, dumps((key, data)))
        entries.add(path)

    def _path(self, key: tuple[Any, ...]) -> Path:
        return self._folder / f"{self._base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"


class _Cache(caching.Cache):  # type: ignore[misc]
    """numba's cache of a function, with another place, key and kind of file."""

    def __init__(self, dispatcher: Any, locator: _Locator, owners: Sequence[str]) -> None:
        self._py_func = dispatcher.py_func
        self._name = repr(self._py_func)
        self._impl = _Results(self._py_func, locator)
        self._cache_path = locator.get_cache_path()
        self._cache_file = _Files(Path(self._cache_path), self._impl.filename_base)
        self._options = repr(sorted(dispatcher.targetoptions.items()))
        self._owners = owners
        self.enable()

    def _save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, unless sources were changed since: they may be of either state."""
        if all(sources.are_unchanged(owner) for owner in self._owners):
            super()._save_overload(sig, data)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        """Return what the code depends on: types, processor, function and sources, options, fields of structures.

        numba's own key pickles what a function closes over, and of compiled functions these pickles change.
        """
        code = hashlib.sha256(self._py_func.__code__.co_code).hexdigest()
        stamp = self._impl.locator.get_source_stamp()
        return sig, codegen.magic_tuple(), code, stamp, self._options, tuple(_fields(sig))


def _fields(kinds: Any) -> Iterator[tuple[str, ...]]:
    """Yield the names of the fields of all structures among types: the layer of a kernel need not be theirs."""
    for kind in kinds:
        if isinstance(kind, BaseTuple):
            structure = getattr(kind, "instance_class", tuple)
            yield structure.__module__, structure.__qualname__, *getattr(structure, "_fields", ())
            yield from _fields(kind)
