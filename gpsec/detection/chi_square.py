"""Chi-square test of the residual."""

from dataclasses import dataclass
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.detection.alarm import Alarms, AlarmState, blank_alarm, decide, gap_before, hold
from gpsec.detection.base import KernelDetector, Observation
from gpsec.detection.ring import mean, push


@dataclass
class ChiSquareState(AlarmState):
    """Attributes beside those of `AlarmState`.

    square: (M, n) ring of the last squared normalised residuals.
    count: (M,) how many of them have been seen.
    """

    square: Floats
    count: Ints

    @classmethod
    def empty(cls, capacity: int, window: int = 1) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(
            **blank_alarm(capacity),
            square=np.zeros((capacity, window)),
            count=np.zeros(capacity, np.int32),
        )


@kernel
def _update(part: Ints, seen: Observation, threshold: Floats, alarms: Alarms, square: Floats, count: Ints) -> None:
    for i in part:
        row = seen.rows[i]
        full = False
        if seen.valid[i]:
            if gap_before(alarms, row):
                count[row] = 0
            z = seen.residual_m[i] / seen.scale_m[i]
            full = push(square, count, row, z * z)
        else:
            alarms.since_valid[row] += 1
        if full:
            decide(alarms, row, mean(square, row), threshold[i])
        else:
            hold(alarms, row)


@dataclass(frozen=True)
class ChiSquare(KernelDetector):
    """Mean of the last n squared residuals in units of what the sensor profile promises.

    q = (1/n)·Σ (z/scale)²: n·q has a chi-square distribution with n degrees of freedom when the residual is white.

    Attributes:
        window: n; scoring begins with the n-th sample.
    """

    name: ClassVar[str] = "chi_square"
    kernel = _update
    window: int = 2

    def new_state(self, capacity: int) -> ChiSquareState:
        """Return the detector's arrays for `capacity` rows."""
        return ChiSquareState.empty(capacity, self.window)

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("ChiSquareState", state)
        return own.square, own.count
