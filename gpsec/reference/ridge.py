"""How much a pixel stands out against the road beside it: the plain twin of `pictures.threshold.ridges`."""

import numpy as np


def plain_ridge(row: np.ndarray, u: int, core: int, gap: int, flank: int) -> float:
    """Return by how many sixteenths of a grey level the pixels about `u` exceed the brighter side of a (W,) row."""
    middle = row[u - core : u + core + 1].astype(float).mean()
    left = row[u - gap - flank + 1 : u - gap + 1].astype(float).mean()
    right = row[u + gap : u + gap + flank].astype(float).mean()
    return 16.0 * float(middle - max(left, right))
