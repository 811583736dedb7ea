"""Honest fixes of a while ago, for attacks that replay them."""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Self

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.tables import Rows


@dataclass
class FixHistory(Rows):
    """A ring of the last S steps for each of N vehicle rows; step k stands in column k mod S.

    Attributes:
        fix_m: (N, S, 2) latest honest fix in the net's frame as of that step.
        valid: (N, S) the vehicle had had one by then.
    """

    fix_m: Floats
    valid: Flags

    @classmethod
    def empty(cls, capacity: int, memory_s: float, step_s: float) -> Self:
        """Return `capacity` rows that reach `memory_s` back."""
        steps = ceil(memory_s / step_s - 1e-6) + 1
        return cls(fix_m=np.zeros((capacity, steps, 2)), valid=np.zeros((capacity, steps), np.bool_))

    def record(self, rows: Ints, step: int, fix_m: Floats, fix_valid: Flags) -> None:
        """Take in the honest fixes of a step, for all vehicle `rows` on the road, in every step.

        Args:
            rows: (n,) vehicle rows; those that departed in this step have been reset.
            step: number of the step.
            fix_m: (N, 2) fixes of all vehicle rows.
            fix_valid: (N,) there is one in this step.
        """
        _record(rows, step, fix_m, fix_valid, self.fix_m, self.valid)

    def reader(self, rows: Ints, step: int, step_s: float) -> Callable[[float], tuple[Floats, Flags]]:
        """Return `Victims.past_fix` for (m,) vehicle rows, after `record` of that step."""

        def past_fix(delay_s: float) -> tuple[Floats, Flags]:
            steps = ceil(delay_s / step_s - 1e-6)
            if not 0 <= steps < self.fix_m.shape[1]:
                reach = (self.fix_m.shape[1] - 1) * step_s
                raise ValueError(f"a fix of {delay_s} s ago was asked for, but the memory is {reach:g} s long")
            column = (step - steps) % self.fix_m.shape[1]
            return self.fix_m[rows, column], self.valid[rows, column]

        return past_fix


@kernel
def _record(rows: Ints, step: int, fix_m: Floats, fix_valid: Flags, ring_m: Floats, ring_valid: Flags) -> None:
    """Write column step mod S: this step's fix, or the one before it where there is none."""
    now = step % ring_valid.shape[1]
    before = (step - 1) % ring_valid.shape[1]
    for row in rows:
        if fix_valid[row]:
            ring_m[row, now, 0] = fix_m[row, 0]
            ring_m[row, now, 1] = fix_m[row, 1]
            ring_valid[row, now] = True
        else:
            ring_m[row, now, 0] = ring_m[row, before, 0]
            ring_m[row, now, 1] = ring_m[row, before, 1]
            ring_valid[row, now] = ring_valid[row, before]
