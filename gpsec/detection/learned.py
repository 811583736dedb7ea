"""What training leaves behind: named arrays, one set per detector, profile and matching."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpsec.core.errors import GpsecError

Learned = Mapping[str, NDArray[Any]]

# progress(stage, done, total)
OnStage = Callable[[str, int, int], None]


def silent(stage: str, done: int, total: int) -> None:
    """Report no progress."""


def array_of(learned: Learned, key: str, kind: type[np.generic], ndim: int) -> NDArray[Any]:
    """Return one array of a model, checked.

    Raises:
        GpsecError: it is missing, of another type or dimension, or not finite.
    """
    if key not in learned:
        raise GpsecError(f"model has no array '{key}'; it holds {', '.join(sorted(learned)) or 'none'}")
    array = learned[key]
    if array.dtype != kind or array.ndim != ndim:
        raise GpsecError(
            f"model array '{key}': expected {ndim}-dimensional {np.dtype(kind)},"
            f" found {array.ndim}-dimensional {array.dtype}"
        )
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise GpsecError(f"model array '{key}': expected finite numbers")
    return array


def scalars(learned: Sequence[Learned], key: str) -> tuple[float, ...]:
    """Return the single positive number `key` of each profile."""
    found = []
    for one in learned:
        value = float(array_of(one, key, np.float64, 0))
        if value <= 0.0:
            raise GpsecError(f"model array '{key}': expected a positive number, found {value}")
        found.append(value)
    return tuple(found)
