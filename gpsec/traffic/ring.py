"""What SUMO's process and the evaluator share: a ring of steps in memory, and what goes through the pipe beside it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.source import Frame

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

    def put(self, frame: Frame) -> Frame:
        """Write the arrays of a step, and return it without them."""
        slot, count = frame.step % DEPTH, len(frame.rows)
        self._whole[slot, 0, :count] = frame.rows
        self._whole[slot, 1, :count] = frame.lane
        self._real[slot, :count] = frame.front_m
        return replace(frame, rows=frame.rows[:0], front_m=frame.front_m[:0], lane=frame.lane[:0])

    def take(self, frame: Frame, count: int) -> Frame:
        """Return a step with copies of its arrays, of `count` vehicles."""
        slot = frame.step % DEPTH
        whole, front_m = self._whole[slot, :, :count], self._real[slot, :count]
        return replace(frame, rows=whole[0].copy(), front_m=front_m.copy(), lane=whole[1].copy())


@dataclass(frozen=True)
class Head:
    """What goes through the pipe for a step.

    Attributes:
        frame: the step; its arrays are empty where they are in the ring.
        in_ring: number of vehicles there, None where the step did not fit.
        sumo_s, read_s: seconds spent so far.
    """

    frame: Frame
    in_ring: int | None
    sumo_s: float
    read_s: float
