"""Two-sided CUSUM of what the LSTM did not expect."""

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import allocating_kernel
from gpsec.detection.alarm import Alarms, AlarmState, decide
from gpsec.detection.base import Observation
from gpsec.detection.blocks import choose
from gpsec.detection.forecast import (
    Doubts,
    Forecaster,
    ForecastState,
    Memory,
    admit,
    blank_forecast,
    foresee,
    remember,
)
from gpsec.detection.lstm import DECAYS
from gpsec.detection.lstm_cell import BLOCK, GATES, HIDDEN, INPUTS, OUTPUTS, SCALES, Network, Step

# By how much more a slow error of prediction adds to the variance at the slowest scale than to that of a single error.
_SLOW_GAIN = (1.0 + DECAYS[-1]) / (1.0 - DECAYS[-1]) - 1.0


@dataclass
class LstmCusumState(ForecastState):
    """Attributes beside those of `ForecastState`.

    up, down: (M,) sums of positive and of negative errors of prediction.
    """

    up: Floats
    down: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(**blank_forecast(capacity), up=np.zeros(capacity), down=np.zeros(capacity))


@allocating_kernel
def _update(
    part: Ints,
    seen: Observation,
    threshold: Floats,
    alarms: Alarms,
    doubts: Doubts,
    slack: float,
    reach: float,
    clip: float,
    margin: float,
    network: Network,
    memory: Memory,
    up: Floats,
    down: Floats,
) -> None:
    step = Step(
        np.empty(BLOCK, np.int32),
        np.empty((BLOCK, len(INPUTS) + HIDDEN), np.float32),
        np.empty((BLOCK, GATES), np.float32),
        np.empty((BLOCK, HIDDEN), np.float32),
        np.empty((BLOCK, OUTPUTS), np.float32),
    )
    due, anew = np.empty(BLOCK, np.bool_), np.empty(BLOCK, np.bool_)
    chosen = np.empty(BLOCK, np.int32)
    for start in range(0, len(part), BLOCK):
        block = part[start : start + BLOCK]
        admit(block, seen, alarms, memory, due, anew)
        for n in range(len(block)):
            row = seen.rows[block[n]]
            # An alarm that is held over the gap goes on until ordinary samples end it.
            if anew[n] and not alarms.alarm[row]:
                up[row], down[row] = 0.0, 0.0
        for profile in range(len(network.offset)):
            ready = choose(chosen, block, due, seen.profile, profile)
            foresee(chosen, ready, seen, network, profile, memory, step)
            for n in range(ready):
                i, row, output = chosen[n], step.row[n], step.output[n]
                z = seen.residual_m[i] / seen.scale_m[i]
                e = min(max((z - output[0]) * sqrt(output[1]), -clip), clip)
                slow = max(1.0 / output[SCALES] - 1.0 / output[1], 0.0) / _SLOW_GAIN
                k = slack + reach * sqrt(slow * output[1])
                plus, minus = max(0.0, up[row] + e - k), max(0.0, down[row] - e - k)
                decide(alarms, row, max(plus, minus), threshold[i])
                cap = threshold[i] + margin * k
                up[row], down[row] = min(plus, cap), min(minus, cap)
                remember(memory, row, z, output[0], alarms.alarm[row], doubts)


@dataclass(frozen=True)
class LstmCusum(Forecaster):
    """Page's cumulative sums of the errors of the LSTM's prediction, in units of the deviation that it expects.

    With e = (z - ẑ)/σ clipped to ±c,

        S⁺ ← max(0, S⁺ + e - k),   S⁻ ← max(0, S⁻ - e - k),   statistic = max(S⁺, S⁻).

    k = slack + reach·σ_s/σ, where σ_s is the deviation of the part of the error that lasts: sums of what lasts would
    wander off without an attack. It follows from what the network expects at its fastest and its slowest scale, as a
    lasting error is in the variance of the latter (1 + λ)/(1 - λ) times. The network is that of `lstm`. The sums are
    capped at threshold + margin·k, as in `cusum`.

    Attributes:
        slack, reach: see above.
        clip: c.
        margin: see above.
    """

    name: ClassVar[str] = "lstm_cusum"
    kernel = _update
    slack: float = 0.5
    reach: float = 2.5
    clip: float = 6.0
    margin: float = 1.0

    def new_state(self, capacity: int) -> LstmCusumState:
        """Return the detector's arrays for `capacity` rows."""
        return LstmCusumState.empty(capacity)

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("LstmCusumState", state)
        return self.doubts, self.slack, self.reach, self.clip, self.margin, self.network, own.memory, own.up, own.down
