"""The last few values of every row, for detectors that look at a window."""

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline


@inline
def push(ring: Floats, count: Ints, row: int, value: float) -> bool:
    """Put a value in place of the oldest of the w in `row`; return whether w have been seen since `count` was 0."""
    size, seen = ring.shape[1], count[row]
    # Counts go round between w and 2w, so that they never overflow.
    ring[row, seen if seen < size else seen - size] = value
    count[row] = seen + 1 if seen + 1 < 2 * size else size
    return bool(seen + 1 >= size)


@inline
def mean(ring: Floats, row: int) -> float:
    """Return the mean of the w values in `row`."""
    total = 0.0
    for j in range(ring.shape[1]):
        total += ring[row, j]
    return float(total / ring.shape[1])
