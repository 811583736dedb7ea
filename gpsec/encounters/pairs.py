"""All pairs of vehicles that touch, or would soon if both went straight on: a grid, then separating axes."""

from math import floor, inf, sqrt
from typing import NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import taken
from gpsec.encounters.rectangles import Bodies, meeting

# Contacts later than this are not looked for.
HORIZON_S = 4.0
# Cells are no smaller, so that all within this distance are looked at: at 30 m/s each, 2 s before oncoming cars meet.
_CELL_M = 120.0
# Primes that spread the cells over the buckets (Teschner et al., VMV 2003).
_PRIME_X, _PRIME_Y = 73_856_093, 19_349_663


class ClosePairs(NamedTuple):
    """Pairs of bodies that meet, C of them; `second` is the body with the lower number.

    Attributes:
        first, second: (C,) bodies.
        gap_m: (C,) along the axis that parts them most, below 0 where they overlap.
        contact_s: (C,) until they touch, 0 where they do.
        closing_mps: (C,) size of their relative velocity.
    """

    first: Ints
    second: Ints
    gap_m: Floats
    contact_s: Floats
    closing_mps: Floats

    @classmethod
    def room(cls, count: int) -> Self:
        """Return room for `count` pairs."""
        first, second = np.zeros(count, np.int32), np.zeros(count, np.int32)
        return cls(first, second, np.zeros(count), np.zeros(count), np.zeros(count))


class _Grid(NamedTuple):
    """Room to sort B bodies into square cells.

    Attributes:
        head: (H,) last body of each bucket, -1 for none; H is a power of two.
        before: (B,) the body before that in its bucket, -1 for none.
        cell_x, cell_y: (B,) cell of each body.
    """

    head: Ints
    before: Ints
    cell_x: Ints
    cell_y: Ints


def close_pairs(bodies: Bodies, horizon_s: float = HORIZON_S) -> ClosePairs:
    """Return the pairs of (B,) bodies that touch, or would within `horizon_s` if both went straight on.

    Only pairs in the same or in adjoining cells of 120 m, or of the largest body, are looked at; all that touch are
    among them.
    """
    count = len(bodies.x_m)
    if count < 2:
        return ClosePairs.room(0)
    longest_m = 2.0 * float(np.sqrt(bodies.half_length_m**2 + bodies.half_width_m**2).max())
    buckets = 1 << (2 * count - 1).bit_length()
    grid = _Grid(np.full(buckets, -1, np.int32), *(np.zeros(count, np.int32) for _ in range(3)))
    cell_m, room, found = max(_CELL_M, longest_m), 4 * count, np.zeros(1, np.int32)
    while True:
        pairs = ClosePairs.room(room)
        collect_pairs(bodies, cell_m, horizon_s, grid, pairs, found)
        if found[0] <= room:
            return taken(pairs, np.arange(found[0], dtype=np.int32))
        room = int(found[0])


@kernel
def collect_pairs(bodies: Bodies, cell_m: float, horizon_s: float, grid: _Grid, pairs: ClosePairs, found: Ints) -> None:
    """Write the pairs that touch within `horizon_s` into `pairs`, as many as it holds, and their number into `found`.

    They come in the order of their first body, and whatever else is the same for equal bodies.
    """
    head, before, cell_x, cell_y = grid
    head[:] = -1
    mask, room, number = len(head) - 1, len(pairs.first), 0
    for i in range(len(bodies.x_m)):
        cell_x[i], cell_y[i] = floor(bodies.x_m[i] / cell_m), floor(bodies.y_m[i] / cell_m)
        for step in range(9):
            x, y = cell_x[i] + step % 3 - 1, cell_y[i] + step // 3 - 1
            j = head[((x * _PRIME_X) ^ (y * _PRIME_Y)) & mask]
            while j >= 0:
                if cell_x[j] == x and cell_y[j] == y:
                    gap, contact = _within(bodies, i, j, horizon_s)
                    if contact <= horizon_s:
                        if number < room:
                            pairs.first[number], pairs.second[number] = i, j
                            pairs.gap_m[number], pairs.contact_s[number] = gap, contact
                            wx, wy = bodies.vx_mps[j] - bodies.vx_mps[i], bodies.vy_mps[j] - bodies.vy_mps[i]
                            pairs.closing_mps[number] = sqrt(wx * wx + wy * wy)
                        number += 1
                j = before[j]
        bucket = ((cell_x[i] * _PRIME_X) ^ (cell_y[i] * _PRIME_Y)) & mask
        before[i] = head[bucket]
        head[bucket] = i
    found[0] = number


@inline
def _within(bodies: Bodies, i: int, j: int, horizon_s: float) -> tuple[float, float]:
    """Return what `meeting` does, or infinities where circles about the bodies do not meet within the horizon."""
    dx, dy = bodies.x_m[j] - bodies.x_m[i], bodies.y_m[j] - bodies.y_m[i]
    wx, wy = bodies.vx_mps[j] - bodies.vx_mps[i], bodies.vy_mps[j] - bodies.vy_mps[i]
    reach = bodies.half_length_m[i] + bodies.half_width_m[i] + bodies.half_length_m[j] + bodies.half_width_m[j]
    reach += horizon_s * sqrt(wx * wx + wy * wy)
    if dx * dx + dy * dy > reach * reach:
        return inf, inf
    return meeting(bodies, i, j)
