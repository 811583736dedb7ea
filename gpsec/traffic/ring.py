"""What SUMO's process and the evaluator share: a ring of steps in memory, and what goes through the pipe beside it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.source import Departure, Frame

# Steps that SUMO may be ahead, and vehicles that a step in the ring may hold; a larger one goes through the pipe.
DEPTH = 16
CAPACITY = 32_768


class Ring:
    """Shared arrays for `DEPTH` steps.

    Attributes:
        capacity: vehicles that a step may hold.
    """

    def __init__(self, whole: Any, real: Any) -> None:
        """Lay the arrays over two blocks of shared memory, of integers and of floats."""
        self._whole: Ints = np.frombuffer(whole, np.int32).reshape(DEPTH, 2, -1)
        self._real: Floats = np.frombuffer(real, np.float64).reshape(DEPTH, -1, 2)
        self.capacity = self._whole.shape[2]

    def put(self, frame: Frame) -> None:
        """Write the arrays of a step."""
        slot, count = frame.step % DEPTH, len(frame.rows)
        self._whole[slot, 0, :count] = frame.rows
        self._whole[slot, 1, :count] = frame.lane
        self._real[slot, :count] = frame.front_m

    def take(self, step: int, count: int) -> tuple[Ints, Floats, Ints]:
        """Return copies of rows, front and lane of a step."""
        whole = self._whole[step % DEPTH, :, :count]
        return whole[0].copy(), self._real[step % DEPTH, :count].copy(), whole[1].copy()


@dataclass(frozen=True)
class Head:
    """What goes through the pipe for a step.

    Attributes:
        step, time_s, left, departures, on_road, spoofers_m: as in `Frame`.
        count: vehicles in the ring.
        sumo_s, read_s: seconds spent so far.
        frame: the whole step where it did not fit the ring.
    """

    step: int
    time_s: float
    left: list[int]
    departures: list[Departure]
    on_road: int
    spoofers_m: Mapping[str, Floats]
    count: int
    sumo_s: float
    read_s: float
    frame: Frame | None
