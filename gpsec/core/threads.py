"""Runs a kernel on disjoint parts of the rows at once; the result is the same for any number of threads."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from gpsec.core.arrays import Ints


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Threads:
    """A pool for kernels that release the GIL.

    Attributes:
        count: number of threads; 1 runs everything in the caller.
    """

    # Below this many rows a second thread costs more than it saves.
    MIN_ROWS = 256

    def __init__(self, count: int = 1) -> None:
        self.count = count
        self._pool = ThreadPoolExecutor(count) if count > 1 else None

    def run(self, kernel: Callable[..., None], rows: Ints, *arguments: object) -> None:
        """Call ``kernel(part, *arguments)`` for parts that together are `rows`."""
        if self._pool is None or len(rows) < 2 * self.MIN_ROWS:
            kernel(rows, *arguments)
            return
        parts = np.array_split(rows, self.count)
        for done in [self._pool.submit(kernel, part, *arguments) for part in parts]:
            done.result()

    def close(self) -> None:
        """Let go of the threads."""
        if self._pool is not None:
            self._pool.shutdown()
