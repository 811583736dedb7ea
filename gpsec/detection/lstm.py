"""LSTM that predicts the residual (Eq 10)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.arrays import Floats, Floats32, Ints
from gpsec.detection.alarm import Alarms, AlarmState, blank_alarm, decide, gap_before, hold
from gpsec.detection.base import KernelDetector, Observation
from gpsec.detection.blocks import choose
from gpsec.detection.learned import Learned, part
from gpsec.detection.lstm_cell import BLOCK, GATES, HIDDEN, INPUTS, Network, Step, for_falling, predict
from gpsec.detection.ring import mean, push
from gpsec.errors import GpsecError
from gpsec.kernels import allocating_kernel, inline

# The network sees the residual up to this many scales: what it may take for a slow error of GNSS is bounded, so a
# spoofed fix that drifts away slowly outruns it.
CLIP = 1.5


@dataclass
class LstmState(AlarmState):
    """Attributes beside those of `AlarmState`.

    hidden, cell: (M, H) of the network.
    fed: (M,) what it was told the last residual was.
    square: (M, n) ring of the last squared errors of prediction.
    count: (M,) how many of them have been seen.
    distrust: (M,) samples for which a residual larger than predicted is still not believed.
    """

    hidden: Floats32
    cell: Floats32
    fed: Floats32
    square: Floats
    count: Ints
    distrust: Ints

    @classmethod
    def empty(cls, capacity: int, window: int = 1) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(
            **blank_alarm(capacity),
            hidden=np.zeros((capacity, HIDDEN), np.float32),
            cell=np.zeros((capacity, HIDDEN), np.float32),
            fed=np.zeros(capacity, np.float32),
            square=np.zeros((capacity, window)),
            count=np.zeros(capacity, np.int32),
            distrust=np.zeros(capacity, np.int32),
        )


@inline
def fill_inputs(inputs: Floats32, n: int, fed: float, seen: Observation, i: int) -> None:
    """Fill in the network's inputs of observation `i`, each of the order of 1: the first K of `inputs[n]`."""
    inputs[n, 0] = min(max(fed, -CLIP), CLIP)
    inputs[n, 1] = min(max(40.0 * seen.curvature_per_m[i], -4.0), 4.0)
    inputs[n, 2] = min(0.05 * seen.speed_mps[i], 4.0)
    inputs[n, 3] = min(seen.camera_sigma_m[i] / seen.scale_m[i], 4.0)


@allocating_kernel
def _update(
    part: Ints,
    seen: Observation,
    threshold: Floats,
    alarms: Alarms,
    patience: int,
    network: Network,
    hidden: Floats32,
    cell: Floats32,
    fed: Floats32,
    square: Floats,
    count: Ints,
    distrust: Ints,
) -> None:
    step = Step(
        np.empty(BLOCK, np.int32),
        np.empty((BLOCK, len(INPUTS) + HIDDEN), np.float32),
        np.empty((BLOCK, GATES), np.float32),
        np.empty((BLOCK, HIDDEN), np.float32),
        np.empty(BLOCK, np.float32),
    )
    due = np.empty(BLOCK, np.bool_)
    chosen = np.empty(BLOCK, np.int32)
    for start in range(0, len(part), BLOCK):
        block = part[start : start + BLOCK]
        for n in range(len(block)):
            i = block[n]
            row = seen.rows[i]
            due[n] = seen.valid[i]
            if not due[n]:
                alarms.since_valid[row] += 1
                hold(alarms, row)
            elif gap_before(alarms, row):
                hidden[row] = 0.0
                cell[row] = 0.0
                fed[row] = 0.0
                count[row] = 0
                # The alarm may still be held; the next score decides whether it is trusted again.
                distrust[row] = 0
        for profile in range(len(network.offset)):
            ready = choose(chosen, block, due, seen.profile, profile)
            for n in range(ready):
                i = chosen[n]
                step.row[n] = seen.rows[i]
                fill_inputs(step.inputs, n, fed[step.row[n]], seen, i)
            predict(step, ready, network, profile, hidden, cell)
            for n in range(ready):
                i, row, prediction = chosen[n], step.row[n], step.prediction[n]
                z = seen.residual_m[i] / seen.scale_m[i]
                error = z - prediction
                if push(square, count, row, error * error):
                    decide(alarms, row, mean(square, row), threshold[i])
                else:
                    hold(alarms, row)
                believed = min(max(z, -CLIP), CLIP)
                if alarms.alarm[row]:
                    distrust[row] = patience
                if distrust[row] > 0 and abs(z) > abs(prediction):
                    believed = prediction
                if distrust[row] > 0 and not alarms.alarm[row]:
                    distrust[row] -= 1
                fed[row] = believed


@dataclass(frozen=True)
class Lstm(KernelDetector):
    """Mean squared error of an LSTM's prediction of the residual: ξ = (1/n)·Σ ((z - ẑ)/scale)² (Eq 10).

    The prediction for this step is made of the residuals before it and of the curvature, the speed and the camera's
    stated deviation now, none of which GNSS can change. While in alarm, and for some samples after, the network is fed
    its own prediction in place of a residual that is larger than it; otherwise it would learn the spoofed bias, fall
    silent, and raise an alarm when the attack ends. A residual that is smaller is believed even then: it leads back
    from what was learned of a slow attack before the alarm.

    Attributes:
        learned: the arrays of each profile's network.
        window: n; scoring begins with the n-th sample.
        distrust: samples after an alarm for which a larger residual is not believed.
    """

    name: ClassVar[str] = "lstm"
    kernel = _update
    learned: tuple[Learned, ...]
    window: int = 2
    distrust: int = 5

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        detector = cls(tuple(learned))
        _ = detector.network
        return detector

    @cached_property
    def network(self) -> Network:
        """The weights of all profiles.

        Raises:
            GpsecError: an array is missing or damaged.
        """
        shapes = {"weight": (len(INPUTS) + HIDDEN, 4 * HIDDEN), "bias": (4 * HIDDEN,), "head": (HIDDEN,), "offset": ()}
        stacks = []
        for key, shape in shapes.items():
            arrays = [part(one, key, np.float32, len(shape)) for one in self.learned]
            for array in arrays:
                if array.shape != shape:
                    raise GpsecError(f"model array '{key}' of the LSTM: expected shape {shape}, found {array.shape}")
            stacks.append(_aligned(arrays))
        network = Network(*stacks)
        for_falling(network.weight)
        for_falling(network.bias)
        return network

    def new_state(self, capacity: int) -> LstmState:
        """Return the detector's arrays for `capacity` rows."""
        return LstmState.empty(capacity, self.window)

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("LstmState", state)
        return self.distrust, self.network, own.hidden, own.cell, own.fed, own.square, own.count, own.distrust


def _aligned(arrays: Sequence[Floats32]) -> Floats32:
    """Return copies of arrays of one shape as one, from the start of a cache line on: no vector spans two of them."""
    stack = np.stack(arrays)
    room = np.empty(stack.size + 16, np.float32)
    first = -room.ctypes.data % 64 // 4
    aligned = room[first : first + stack.size].reshape(stack.shape)
    aligned[:] = stack
    return aligned
