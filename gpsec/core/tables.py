"""Structures of arrays whose first axis is the row, and the rows that are handed out in them.

A structure is declared once, as a ``NamedTuple`` of arrays with what a fresh row holds in each:

    class Tracks(NamedTuple):
        vehicle: Ints = blank(-1)
        fix_m: Floats = blank(0.0, 2)
        mean: Floats = blank(0.0, "defences", "states")

    tracks = Table(Tracks, capacity=1, defences=3, states=5)

The table owns the arrays; `Table.now` is the structure itself, for numpy and for kernels alike. A field may be a
structure too, which several others have in common: ``memory: Memory = Memory()``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import Any, Generic, NamedTuple, TypeVar, cast

import numpy as np

from gpsec.core.arrays import Flags, Ints

T = TypeVar("T", bound=NamedTuple)

# What a Python number is in an array; a value of a numpy type keeps its own.
_DTYPES: dict[type, type[np.generic]] = {bool: np.bool_, int: np.int32, float: np.float64}


@dataclass(frozen=True)
class Blank:
    """What a fresh row holds: `value` in each element of an array of `shape`, whose named lengths a table knows."""

    value: Any
    shape: tuple[int | str, ...]

    def row(self, lengths: dict[str, int]) -> np.ndarray:
        """Return an array (1, …) of one fresh row."""
        shape = tuple(lengths[length] if isinstance(length, str) else length for length in self.shape)
        return np.full((1, *shape), self.value, _DTYPES.get(type(self.value)))


def blank(value: bool | float | np.generic, *shape: int | str) -> Any:
    """Declare a field of a structure: what a fresh row holds, and the shape of a row (a number, if there is none).

    A length that only the run knows is given by name, and to the `Table` by keyword. A Python bool, int or float makes
    an array of bool, int32 or float64, a numpy scalar one of its type.
    """
    return Blank(value, shape)


class Table(Generic[T]):
    """The rows of one structure.

    Attributes:
        now: the structure of arrays, row first. It is another one after the table has grown.
    """

    def __init__(self, structure: type[T], capacity: int = 1, /, **lengths: int) -> None:
        """Make `capacity` fresh rows of `structure`; `lengths` are those that it names.

        Raises:
            KeyError: a length that the structure names is not given.
        """
        self._declared = structure(*structure._field_defaults.values())
        self._fresh = [cast("Blank", declared).row(lengths) for declared in _leaves(self._declared)]
        self._capacity = 0
        self._take([row[:0] for row in self._fresh])
        self.grow(capacity)

    def _take(self, arrays: list[np.ndarray]) -> None:
        self._arrays = arrays
        self.now: T = _like(self._declared, iter(arrays))

    @property
    def capacity(self) -> int:
        """Number of rows that there is room for."""
        return self._capacity

    def arrays(self) -> list[np.ndarray]:
        """Return all arrays, those of structures in the structure, too."""
        return self._arrays

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` rows; the new ones are fresh."""
        old = self._capacity
        if old >= capacity:
            return
        arrays = []
        for array, fresh in zip(self.arrays(), self._fresh, strict=True):
            # Zeros take no memory until something is written to them.
            grown = np.zeros((capacity, *fresh.shape[1:]), fresh.dtype)
            grown[:old] = array
            if fresh.any():
                grown[old:] = fresh
            arrays.append(grown)
        self._take(arrays)
        self._capacity = capacity

    def reset(self, rows: Ints) -> None:
        """Make `rows` fresh again."""
        for array, fresh in zip(self.arrays(), self._fresh, strict=True):
            array[rows] = fresh

    def copy(self, source: Ints, target: Ints) -> None:
        """Copy the rows `source` onto the rows `target`, pair by pair."""
        for array in self.arrays():
            array[target] = array[source]


def taken(structure: T, rows: Ints | Flags) -> T:
    """Return a copy of some rows of a structure of arrays (numbers, or one flag a row)."""
    made: T = _like(structure, (array[rows] for array in _leaves(structure)))
    return made


def concatenated(structures: Sequence[T]) -> T:
    """Return the rows of one or more structures of arrays, one after the other."""
    columns = zip(*map(_leaves, structures), strict=True)
    made: T = _like(structures[0], (np.concatenate(arrays) for arrays in columns))
    return made


def _leaves(structure: Any) -> Iterator[Any]:
    """Yield what the fields of a structure hold, and those of the structures in it."""
    for value in structure:
        if isinstance(value, tuple):
            yield from _leaves(value)
        else:
            yield value


def _like(structure: Any, values: Iterator[Any]) -> Any:
    """Return a structure like another one whose fields hold `values`."""
    return structure._make(_like(value, values) if isinstance(value, tuple) else next(values) for value in structure)


class Slots:
    """Hands out row numbers, always the lowest that is free."""

    def __init__(self) -> None:
        self._free: list[int] = []
        self.used = 0

    def take(self) -> int:
        """Return a free row."""
        if self._free:
            return heappop(self._free)
        self.used += 1
        return self.used - 1

    def give_back(self, row: int) -> None:
        """Make `row` free again; it must be in use."""
        heappush(self._free, row)
