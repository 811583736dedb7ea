"""What detectors share that ask the LSTM what the residual should be: its memory, what it is told, what it forgets."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Floats32, Ints
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import allocating_kernel, always_inline, inline
from gpsec.core.tables import blank
from gpsec.detection.base import Observation
from gpsec.detection.families import KernelDetector
from gpsec.detection.learned import Learned, array_of
from gpsec.detection.lstm_cell import CELL_BLOCK, GATES, HIDDEN, INPUTS, OUTPUTS, Network, Step, for_falling, take_step

# The network sees the residual up to this many scales: what it may take for a slow error of GNSS is bounded, so a
# spoofed fix that drifts away slowly outruns it.
CLIP = 1.5
# Samples after which `lstm_glr` tells its network a residual, so that a slow attack is not learned before it can be
# seen. GNSS errors are so slow that those of two seconds ago say nearly as much.
DELAY = 20


class ForecastState(NamedTuple):
    """What the network and what it is told remember of M rows; a detector that asks it adds its own.

    Attributes:
        hidden, cell: (M, H) of the network.
        queue: (M, D) ring of the residuals that it is still to be told, D being `Forecaster.delay`.
        at: (M,) where the oldest of them is.
        distrust: (M,) samples for which a large residual is still not believed.
    """

    hidden: Floats32 = blank(np.float32(0.0), HIDDEN)
    cell: Floats32 = blank(np.float32(0.0), HIDDEN)
    queue: Floats32 = blank(np.float32(0.0), "delay")
    at: Ints = blank(0)
    distrust: Ints = blank(0)


class ForecastSettings(NamedTuple):
    """What all detectors that ask the network are set to.

    Attributes:
        network: the weights.
        distrust, plausible: see `Forecaster`.
    """

    network: Network
    distrust: int
    plausible: float


@allocating_kernel
def workspace() -> Step:
    """Return the arrays that a block of rows takes a step in."""
    return Step(
        np.empty(CELL_BLOCK, np.int32),
        np.empty((CELL_BLOCK, len(INPUTS) + HIDDEN), np.float32),
        np.empty((CELL_BLOCK, GATES), np.float32),
        np.empty((CELL_BLOCK, HIDDEN), np.float32),
        np.empty((CELL_BLOCK, OUTPUTS), np.float32),
    )


@always_inline
def foresee(chosen: Ints, count: int, state: Any, seen: Observation, settings: Any, profile: int, work: Step) -> None:
    """Let the network say what it expects of the first `count` of the chosen observations, all of one profile.

    `state` and `settings` are those of a detector, whose fields `forecast` are `ForecastState` and `ForecastSettings`.
    """
    forecast = state.forecast
    for n in range(count):
        i = chosen[n]
        row = seen.rows[i]
        work.row[n] = row
        # Each of the order of 1.
        work.inputs[n, 0] = min(max(forecast.queue[row, forecast.at[row]], -CLIP), CLIP)
        work.inputs[n, 1] = min(max(40.0 * seen.curvature_per_m[i], -4.0), 4.0)
        work.inputs[n, 2] = min(0.05 * seen.speed_mps[i], 4.0)
        work.inputs[n, 3] = min(seen.camera_sigma_m[i] / seen.scale_m[i], 4.0)
    take_step(work, count, settings.forecast.network, profile, forecast.hidden, forecast.cell)


@inline
def forget(forecast: ForecastState, row: int) -> None:
    """Begin anew; of the alarm that may still be held, the next score decides whether the residual is trusted again."""
    for j in range(HIDDEN):
        forecast.hidden[row, j] = 0.0
        forecast.cell[row, j] = 0.0
    for j in range(forecast.queue.shape[1]):
        forecast.queue[row, j] = 0.0
    forecast.distrust[row] = 0


@inline
def remember(
    forecast: ForecastState, row: int, z: float, prediction: float, settings: ForecastSettings, alarm: bool
) -> None:
    """Queue the normalised residual for the network, or the prediction where the residual is not believed."""
    believed = z
    if alarm:
        forecast.distrust[row] = settings.distrust
    if forecast.distrust[row] > 0:
        if abs(z) > max(abs(prediction), settings.plausible):
            believed = prediction
        if not alarm:
            forecast.distrust[row] -= 1
    at = forecast.at[row]
    forecast.queue[row, at] = min(max(believed, -CLIP), CLIP)
    forecast.at[row] = at + 1 if at + 1 < forecast.queue.shape[1] else 0


@always_inline
def remember_residual(
    state: Any, seen: Observation, i: int, settings: Any, threshold: float, alarm: bool, work: Step, n: int
) -> None:
    """Do what `each_block` asks of a detector that remembers nothing but its forecast: queue the residual."""
    z = seen.residual_m[i] / seen.scale_m[i]
    remember(state.forecast, seen.rows[i], z, work.output[n, 0], settings.forecast, alarm)


@dataclass(frozen=True)
class Forecaster(KernelDetector):
    """A detector that compares the residual with what the LSTM expects.

    The prediction for this step is made of the residuals up to `delay` samples before it and of the curvature, the
    speed and the camera's stated deviation now, none of which GNSS can change. While in alarm, and for some samples
    after, the network is told its own prediction in place of a residual that is larger than both it and what is
    plausible; otherwise it would learn the spoofed bias, fall silent, and raise an alarm when the attack ends. What is
    smaller is believed even then: it leads out of a false alarm, and back from what was learned of a slow attack.

    Attributes:
        delay: samples after which a residual is told to the network.
        outputs: what the network says: the residual that it expects and, where there are more, log-variances.
        learned: the arrays of each profile's network.
        distrust: samples after an alarm for which a larger residual is not believed.
        plausible: residuals up to that many scales are believed always.
    """

    delay: ClassVar[int] = DELAY
    outputs: ClassVar[int] = OUTPUTS
    learned: tuple[Learned, ...]
    distrust: int = 5
    plausible: float = 2.0

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        detector = cls(tuple(learned))
        _ = detector.forecast
        return detector

    @cached_property
    def forecast(self) -> ForecastSettings:
        """The network and what it is told, as kernels read them.

        Raises:
            GpsecError: an array is missing or damaged.
        """
        return ForecastSettings(self._network(), self.distrust, self.plausible)

    def _network(self) -> Network:
        """Return the weights of all profiles."""
        shapes = {
            "weight": (len(INPUTS) + HIDDEN, GATES),
            "bias": (GATES,),
            "head": (HIDDEN, self.outputs),
            "offset": (self.outputs,),
        }
        stacks = []
        for key, shape in shapes.items():
            arrays = [array_of(one, key, np.float32, len(shape)) for one in self.learned]
            for array in arrays:
                if array.shape != shape:
                    raise GpsecError(f"model array '{key}' of the LSTM: expected shape {shape}, found {array.shape}")
            stacks.append(_aligned([_widened(a) for a in arrays] if shape[-1] == self.outputs else arrays))
        network = Network(*stacks)
        for_falling(network.weight)
        for_falling(network.bias)
        return network


def _widened(head: Floats32) -> Floats32:
    """Return weights or offsets (…, Q) of a head with `OUTPUTS` of them; what the network does not say is 0."""
    return np.pad(head, [(0, 0)] * (head.ndim - 1) + [(0, OUTPUTS - head.shape[-1])])


def _aligned(arrays: Sequence[Floats32]) -> Floats32:
    """Return copies of arrays of one shape as one, from the start of a cache line on: no vector spans two of them."""
    stack = np.stack(arrays)
    space = np.empty(stack.size + 16, np.float32)
    first = -space.ctypes.data % 64 // 4
    aligned = space[first : first + stack.size].reshape(stack.shape)
    aligned[:] = stack
    return aligned
