"""The threshold: what is brighter, or more yellow, than the road on both sides of it, and as wide as paint.

A line of paint is a ridge across a row of the picture: its middle stands out against the road to its left and to its
right. How wide it appears follows from the row's distance, so that what is far too wide (a white car) or has one edge
only (the border of a shadow) leaves nothing.
"""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.kernels import kernel

# What must be paint about the middle of a line, and where the road beside it begins and how much of it is compared:
# lines of 0.1 to 0.4 m pass.
CORE_M, ROAD_FROM_M, ROAD_M = 0.10, 0.20, 0.15
# A ridge stands out by so many deviations of those that the road itself has, and by so many grey levels.
_DEVIATIONS, _LEAST = 4.0, 6
NOT_LOOKED_AT = -32768
"""Of a pixel that is not looked at."""
# Grey level over the threshold -> score.
_GAIN = 4


class RidgeRows(NamedTuple):
    """How wide a line of paint is in each of (R,) rows, in pixels, and which columns of it are looked at.

    Attributes:
        core: half of what is compared with the road; the middle pixel comes on top.
        gap, flank: where the road begins, counted from the middle, and how wide a piece of it is compared.
        first, last: columns, the last one not included.
    """

    core: Ints
    gap: Ints
    flank: Ints
    first: Ints
    last: Ints


@kernel
def ridges(bright: np.ndarray, yellow: np.ndarray, rows: RidgeRows, total: Ints, found: np.ndarray) -> None:
    """Fill `found` (R, W) with by how much each pixel stands out in either channel, in sixteenths.

    Where a row is not looked at it is `NOT_LOOKED_AT`. `bright` and `yellow` are (R, W) channels of bytes; `total`
    (2, W + 1) is room to work in.
    """
    count, width = bright.shape
    first, second = total[0], total[1]
    for row in range(count):
        core, gap, flank = rows.core[row], rows.gap[row], rows.flank[row]
        for u in range(width):
            found[row, u] = NOT_LOOKED_AT
            first[u + 1] = first[u] + bright[row, u]
            second[u + 1] = second[u] + yellow[row, u]
        reach = gap + flank
        # The mean of the middle less that of the brighter side, by sums.
        middle, side = np.float32(16.0 / (2 * core + 1)), np.float32(16.0 / flank)
        for u in range(max(rows.first[row], reach), min(rows.last[row], width - reach)):
            a, b, c, d = u - reach + 1, u - gap + 1, u + gap, u + reach
            one = middle * (first[u + core + 1] - first[u - core]) - side * max(
                first[b] - first[a], first[d] - first[c]
            )
            two = middle * (second[u + core + 1] - second[u - core]) - side * max(
                second[b] - second[a], second[d] - second[c]
            )
            found[row, u] = np.int16(max(one, two))


def over_threshold(found: np.ndarray) -> np.ndarray:
    """Return the (R, W) bytes by how much ridges (R, W) exceed the threshold, which their own spread sets."""
    sample = found[::3, ::5]
    sample = sample[sample > NOT_LOOKED_AT]
    if not len(sample):
        return np.zeros(found.shape, np.uint8)
    low, middle = np.quantile(sample, (0.16, 0.5))  # paint is in the upper half
    level = max(float(middle + _DEVIATIONS * (middle - low)), 16.0 * _LEAST)
    over: np.ndarray = np.clip((found.astype(np.float32) - level) * (_GAIN / 16.0), 0.0, 255.0).astype(np.uint8)
    return over
