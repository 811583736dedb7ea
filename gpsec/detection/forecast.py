"""What detectors share that ask the LSTM what the residual should be: its memory, what it is told, what it forgets."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Flags, Floats32, Ints
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import inline
from gpsec.detection.alarm import Alarms, AlarmState, blank_alarm, gap_before, hold
from gpsec.detection.base import KernelDetector, Observation
from gpsec.detection.learned import Learned, part
from gpsec.detection.lstm_cell import GATES, HIDDEN, INPUTS, OUTPUTS, Network, Step, for_falling, predict

# The network sees the residual up to this many scales: what it may take for a slow error of GNSS is bounded, so a
# spoofed fix that drifts away slowly outruns it.
CLIP = 1.5
# Samples after which a residual is told to the network, so that a slow attack is not learned before it can be seen.
# GNSS errors are so slow that those of two seconds ago say nearly as much.
DELAY = 20


@dataclass
class ForecastState(AlarmState):
    """Attributes beside those of `AlarmState`.

    hidden, cell: (M, H) of the network.
    queue: (M, D) ring of the residuals that it is still to be told.
    at: (M,) where the oldest of them is.
    distrust: (M,) samples for which a large residual is still not believed.
    """

    hidden: Floats32
    cell: Floats32
    queue: Floats32
    at: Ints
    distrust: Ints

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(**blank_forecast(capacity))

    @property
    def memory(self) -> "Memory":
        """The arrays as a kernel takes them."""
        return Memory(self.hidden, self.cell, self.queue, self.at, self.distrust)


def blank_forecast(capacity: int) -> dict[str, np.ndarray]:
    """Return the fields of `ForecastState` for `capacity` rows, for the constructor of a subclass."""
    return {
        **blank_alarm(capacity),
        "hidden": np.zeros((capacity, HIDDEN), np.float32),
        "cell": np.zeros((capacity, HIDDEN), np.float32),
        "queue": np.zeros((capacity, DELAY), np.float32),
        "at": np.zeros(capacity, np.int32),
        "distrust": np.zeros(capacity, np.int32),
    }


class Memory(NamedTuple):
    """The arrays of `ForecastState` that are the network's."""

    hidden: Floats32
    cell: Floats32
    queue: Floats32
    at: Ints
    distrust: Ints


class Doubts(NamedTuple):
    """What a `Forecaster` does not believe."""

    distrust: int
    plausible: float


@inline
def admit(block: Ints, seen: Observation, alarms: Alarms, memory: Memory, due: Flags, anew: Flags) -> None:
    """Set which observations of a block are due for a score, and which of these begin anew after a gap."""
    for n in range(len(block)):
        i = block[n]
        row = seen.rows[i]
        due[n] = seen.valid[i]
        anew[n] = False
        if not due[n]:
            alarms.since_valid[row] += 1
            hold(alarms, row)
        elif gap_before(alarms, row):
            anew[n] = True
            for j in range(HIDDEN):
                memory.hidden[row, j] = 0.0
                memory.cell[row, j] = 0.0
            for j in range(DELAY):
                memory.queue[row, j] = 0.0
            # The alarm may still be held; the next score decides whether it is trusted again.
            memory.distrust[row] = 0


@inline
def foresee(
    chosen: Ints, ready: int, seen: Observation, network: Network, profile: int, memory: Memory, step: Step
) -> None:
    """Let the network say what it expects of the first `ready` of the chosen observations, all of one profile."""
    for n in range(ready):
        i = chosen[n]
        row = seen.rows[i]
        step.row[n] = row
        # Each of the order of 1.
        step.inputs[n, 0] = min(max(memory.queue[row, memory.at[row]], -CLIP), CLIP)
        step.inputs[n, 1] = min(max(40.0 * seen.curvature_per_m[i], -4.0), 4.0)
        step.inputs[n, 2] = min(0.05 * seen.speed_mps[i], 4.0)
        step.inputs[n, 3] = min(seen.camera_sigma_m[i] / seen.scale_m[i], 4.0)
    predict(step, ready, network, profile, memory.hidden, memory.cell)


@inline
def remember(memory: Memory, row: int, z: float, prediction: float, alarm: bool, doubts: Doubts) -> None:
    """Queue the normalised residual for the network, or the prediction where the residual is not believed."""
    believed = z
    if alarm:
        memory.distrust[row] = doubts.distrust
    if memory.distrust[row] > 0:
        if abs(z) > max(abs(prediction), doubts.plausible):
            believed = prediction
        if not alarm:
            memory.distrust[row] -= 1
    at = memory.at[row]
    memory.queue[row, at] = min(max(believed, -CLIP), CLIP)
    memory.at[row] = at + 1 if at + 1 < DELAY else 0


@dataclass(frozen=True)
class Forecaster(KernelDetector):
    """A detector that compares the residual with what the LSTM expects.

    The prediction for this step is made of the residuals up to `DELAY` samples before it and of the curvature, the
    speed and the camera's stated deviation now, none of which GNSS can change. While in alarm, and for some samples
    after, the network is told its own prediction in place of a residual that is larger than both it and what is
    plausible; otherwise it would learn the spoofed bias, fall silent, and raise an alarm when the attack ends. What is
    smaller is believed even then: it leads out of a false alarm, and back from what was learned of a slow attack.

    Attributes:
        learned: the arrays of each profile's network.
        distrust: samples after an alarm for which a larger residual is not believed.
        plausible: residuals up to that many scales are believed always.
    """

    learned: tuple[Learned, ...]
    distrust: int = 5
    plausible: float = 2.0

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        detector = cls(tuple(learned))
        _ = detector.network
        return detector

    @property
    def doubts(self) -> Doubts:
        """What is not believed, as a kernel reads it."""
        return Doubts(self.distrust, self.plausible)

    @cached_property
    def network(self) -> Network:
        """The weights of all profiles.

        Raises:
            GpsecError: an array is missing or damaged.
        """
        shapes = {
            "weight": (len(INPUTS) + HIDDEN, GATES),
            "bias": (GATES,),
            "head": (HIDDEN, OUTPUTS),
            "offset": (OUTPUTS,),
        }
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


def _aligned(arrays: Sequence[Floats32]) -> Floats32:
    """Return copies of arrays of one shape as one, from the start of a cache line on: no vector spans two of them."""
    stack = np.stack(arrays)
    space = np.empty(stack.size + 16, np.float32)
    first = -space.ctypes.data % 64 // 4
    aligned = space[first : first + stack.size].reshape(stack.shape)
    aligned[:] = stack
    return aligned
