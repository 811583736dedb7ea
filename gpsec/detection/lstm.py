"""LSTM that predicts the residual (Eq 10)."""

from dataclasses import dataclass
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.core.arrays import Floats, Floats32, Ints
from gpsec.core.kernels import allocating_kernel, inline
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
from gpsec.detection.lstm_cell import BLOCK, GATES, HIDDEN, INPUTS, OUTPUTS, SCALES, Network, Step

# Weight of an error of prediction relative to that of the next one, at each time scale: this sample alone, and means
# over the last 2.5 and 6.7 of them. An attack that grows by 1/decay a sample is seen best at the scale of that decay.
DECAYS = (0.0, 0.6, 0.85)


@dataclass
class LstmState(ForecastState):
    """Attributes beside those of `ForecastState`.

    evidence: (M, S) weighted sums of the errors of prediction.
    weight: (M, S) sums of the squared weights.
    """

    evidence: Floats
    weight: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        shape = (capacity, SCALES)
        return cls(**blank_forecast(capacity), evidence=np.zeros(shape), weight=np.zeros(shape))


@inline
def contradicts(evidence: Floats, weight: Floats, row: int, error: float, output: Floats32, enough: float) -> bool:
    """Return whether an error of prediction is much likelier without the offset that was seen so far than with it.

    That offset m is the mean at the scale with the largest statistic, and the logarithm of the likelihood ratio of
    e ~ N(m, σ²) and e ~ N(0, σ²) is (m·e - m²/2)/σ².
    """
    largest, offset = 0.0, 0.0
    for s in range(SCALES):
        if weight[row, s] > 0.0:
            value = evidence[row, s] * evidence[row, s] / weight[row, s] * output[1 + s]
            if value > largest:
                largest, offset = value, evidence[row, s] * (1.0 - DECAYS[s])
    return bool((offset * error - 0.5 * offset * offset) * output[1] < -enough)


@allocating_kernel
def _update(
    part: Ints,
    seen: Observation,
    threshold: Floats,
    alarms: Alarms,
    doubts: Doubts,
    enough: float,
    network: Network,
    memory: Memory,
    evidence: Floats,
    weight: Floats,
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
            if anew[n]:
                evidence[seen.rows[block[n]]] = 0.0
                weight[seen.rows[block[n]]] = 0.0
        for profile in range(len(network.offset)):
            ready = choose(chosen, block, due, seen.profile, profile)
            foresee(chosen, ready, seen, network, profile, memory, step)
            for n in range(ready):
                i, row, output = chosen[n], step.row[n], step.output[n]
                z = seen.residual_m[i] / seen.scale_m[i]
                error = z - output[0]
                if alarms.alarm[row] and contradicts(evidence, weight, row, error, output, enough):
                    evidence[row] = 0.0
                    weight[row] = 0.0
                value = 0.0
                for s in range(SCALES):
                    evidence[row, s] = DECAYS[s] * evidence[row, s] + error
                    weight[row, s] = DECAYS[s] * DECAYS[s] * weight[row, s] + 1.0
                    value = max(value, evidence[row, s] * evidence[row, s] / weight[row, s] * output[1 + s])
                decide(alarms, row, value, threshold[i])
                remember(memory, row, z, output[0], alarms.alarm[row], doubts)


@dataclass(frozen=True)
class Lstm(Forecaster):
    """Squared error of an LSTM's prediction of the residual, in units of the variance that the network expects of it.

    With the errors e = (z - ẑ)/scale, time scales of decay λ, and σ_λ² as the network predicts it,

        ξ = max over λ of (Σ λʲ·e_{t-j})² / (Σ λ²ʲ · σ_λ²).

    This is Eq 10 (ξ = (z - ẑ)² at λ = 0) with three changes: errors are averaged before they are squared, since an
    attack moves all of them to one side and noise does not; over several windows at once, since it is not known how
    fast the attack is; and each in units of its own variance. While in alarm, an error that is `enough` times (as a
    logarithm) likelier without the offset than with it ends the evidence: the attack is over, and so is the alarm.

    Attributes:
        enough: see above.
    """

    name: ClassVar[str] = "lstm"
    kernel = _update
    enough: float = 3.0

    def new_state(self, capacity: int) -> LstmState:
        """Return the detector's arrays for `capacity` rows."""
        return LstmState.empty(capacity)

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("LstmState", state)
        return self.doubts, self.enough, self.network, own.memory, own.evidence, own.weight
