"""Strips on the ground, such as a dash of paint or a lane's surface, and which of them are near."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.core.tables import taken

_CELL_M = 32.0


class Strips(NamedTuple):
    """Strips by the n cross sections that they are made of.

    Attributes:
        left_m, right_m: (n, 2) ends of each cross section in the net's frame.
        strip: (n,) number of the strip; those of one strip lie together, in order.
        kind: (n,) what the strip is.
        wear: (n,) 0 … 1, how soon it is worn off here.
    """

    left_m: Floats
    right_m: Floats
    strip: Longs
    kind: Ints
    wear: Floats


def join_strips(pieces: Sequence[tuple[Floats, Floats, int, Floats]]) -> Strips:
    """Return strips of (left (n, 2), right (n, 2), kind, wear (n,)), numbered in their order."""
    count = [len(left) for left, _, _, _ in pieces]
    return Strips(
        np.concatenate([left for left, _, _, _ in pieces] or [np.zeros((0, 2))]),
        np.concatenate([right for _, right, _, _ in pieces] or [np.zeros((0, 2))]),
        np.repeat(np.arange(len(pieces)), count),
        np.repeat(np.array([kind for _, _, kind, _ in pieces], np.int32), count),
        np.concatenate([wear for _, _, _, wear in pieces] or [np.zeros(0)]),
    )


@dataclass(frozen=True)
class Painted:
    """Strips that are looked up by place: a cross section is in the square cell of its left end.

    Attributes:
        strips: all of them.
    """

    strips: Strips
    _first: Longs
    _row: Longs
    _corner: Longs
    _size: tuple[int, int]

    @classmethod
    def of(cls, strips: Strips) -> "Painted":
        """Sort the cross sections of `strips` into cells."""
        cell = np.floor(strips.left_m / _CELL_M).astype(np.int64)
        corner = cell.min(axis=0) if len(cell) else np.zeros(2, np.int64)
        columns, rows = (np.ptp(cell, axis=0) + 1).tolist() if len(cell) else (1, 1)
        number = (cell[:, 1] - corner[1]) * columns + cell[:, 0] - corner[0]
        order = np.argsort(number, kind="stable")
        first = np.searchsorted(number[order], np.arange(rows * columns + 1))
        return cls(strips, first, order, corner, (columns, rows))

    def near(self, place_m: Floats, radius_m: float) -> Strips:
        """Return the cross sections in the cells that a square of ± `radius_m` about a place touches, in order."""
        low = np.floor((place_m - radius_m) / _CELL_M).astype(np.int64) - self._corner
        high = np.floor((place_m + radius_m) / _CELL_M).astype(np.int64) - self._corner
        columns, rows = self._size
        a, b = max(int(low[0]), 0), min(int(high[0]), columns - 1)
        if b < a:
            return taken(self.strips, np.zeros(0, np.int32))
        lines = range(max(int(low[1]), 0), min(int(high[1]), rows - 1) + 1)
        found = [self._row[self._first[j * columns + a] : self._first[j * columns + b + 1]] for j in lines]
        chosen = np.sort(np.concatenate(found)).astype(np.int32) if found else np.zeros(0, np.int32)
        return taken(self.strips, chosen)


def runs(strips: Strips, shown: Flags, level: Ints) -> list[slice]:
    """Return the runs of two or more cross sections of one strip that are all shown and of one `level`.

    Where the level of a strip changes, the next run begins with the last cross section of the one before, so that
    nothing is missing between them; its own level is that of its second cross section.
    """
    if len(shown) < 2:
        return []
    joined = shown[:-1] & shown[1:] & (strips.strip[1:] == strips.strip[:-1])
    found = []
    change = np.flatnonzero(np.diff(np.concatenate([[False], joined, [False]]).astype(np.int8)))
    for first, last in change.reshape(-1, 2).tolist():
        cuts = first + 1 + np.flatnonzero(np.diff(level[first + 1 : last + 1]))
        edges = [first, *cuts.tolist(), last]
        found += [slice(a, b + 1) for a, b in pairwise(edges)]
    return found
