"""How a loop over rows becomes machine code."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first use and cache the machine code beside its module.

    Kernels release the GIL, so that `gpsec.threads` can run them on disjoint rows at once, and never use
    fast-math: the same input gives the same bits whatever the batch.
    """
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small helper that kernels call; the optimiser inlines it."""
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True, error_model="numpy")(function))
