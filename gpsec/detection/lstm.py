"""LSTM that predicts the residual (Eq 10)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, Self, cast

import numpy as np

from gpsec.arrays import Flags, Floats, Floats32, Ints
from gpsec.detection.alarm import (
    GAP_S,
    HOLD_S,
    AlarmState,
    blank_alarm,
    decide,
    gap_before,
    hold,
    run_on,
    steps_in,
)
from gpsec.detection.base import Detector, Observation, Verdict
from gpsec.detection.learned import Learned, part
from gpsec.detection.lstm_cell import step_cell
from gpsec.detection.ring import mean, push
from gpsec.errors import GpsecError
from gpsec.fleet import Rows
from gpsec.kernels import allocating_kernel, inline
from gpsec.threads import Threads

HIDDEN = 32
INPUTS = ("last residual", "curvature", "speed", "camera sigma")
# The network sees the residual up to this many scales: what it may take for a slow error of GNSS is bounded, so a
# spoofed fix that drifts away slowly outruns it.
CLIP = 1.5


class Network(NamedTuple):
    """The weights of P profiles.

    Attributes:
        weight: (P, K + H, 4H) of inputs, then hidden units; gates in the order i, f, g, o.
        bias: (P, 4H).
        head: (P, H) of the prediction.
        offset: (P,) of the prediction.
    """

    weight: Floats32
    bias: Floats32
    head: Floats32
    offset: Floats32


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


@dataclass(frozen=True)
class Lstm(Detector):
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
            stacks.append(cast("Floats32", np.stack(arrays)))
        return Network(*stacks)

    def new_state(self, capacity: int) -> LstmState:
        """Return the detector's arrays for `capacity` rows."""
        return LstmState.empty(capacity, self.window)

    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Take one step."""
        own = cast("LstmState", state)
        verdict = Verdict.blank(len(observation.rows))
        run_on(threads).run(
            _update,
            np.arange(len(observation.rows), dtype=np.int32),
            observation.rows,
            observation.profile,
            observation.residual_m,
            observation.valid,
            observation.scale_m,
            observation.speed_mps,
            observation.curvature_per_m,
            observation.camera_sigma_m,
            threshold,
            steps_in(GAP_S, observation.step_s),
            steps_in(HOLD_S, observation.step_s),
            self.distrust,
            self.network,
            own.hidden,
            own.cell,
            own.fed,
            own.square,
            own.count,
            own.distrust,
            own.alarm,
            own.since_valid,
            own.since_scored,
            verdict.statistic,
            verdict.scored,
            verdict.alarm,
        )
        return verdict


@inline
def fill_inputs(
    inputs: Floats32, fed: float, curvature_per_m: float, speed_mps: float, camera_sigma_m: float, scale_m: float
) -> None:
    """Fill in the network's (K,) inputs, each of the order of 1."""
    inputs[0] = min(max(fed, -CLIP), CLIP)
    inputs[1] = min(max(40.0 * curvature_per_m, -4.0), 4.0)
    inputs[2] = min(0.05 * speed_mps, 4.0)
    inputs[3] = min(camera_sigma_m / scale_m, 4.0)


@allocating_kernel
def _update(
    part: Ints,
    rows: Ints,
    profile: Ints,
    residual_m: Floats,
    valid: Flags,
    scale_m: Floats,
    speed_mps: Floats,
    curvature_per_m: Floats,
    camera_sigma_m: Floats,
    threshold: Floats,
    gap_steps: int,
    hold_steps: int,
    patience: int,
    network: Network,
    hidden: Floats32,
    cell: Floats32,
    fed: Floats32,
    square: Floats,
    count: Ints,
    distrust: Ints,
    alarm: Flags,
    since_valid: Ints,
    since_scored: Ints,
    statistic: Floats,
    scored: Flags,
    alarms: Flags,
) -> None:
    inputs = np.empty(len(INPUTS), np.float32)
    gates = np.empty(network.bias.shape[1], np.float32)
    for i in part:
        row = rows[i]
        if not valid[i]:
            since_valid[row] += 1
            hold(i, row, hold_steps, alarm, since_scored, statistic, scored, alarms)
            continue
        if gap_before(since_valid, row, gap_steps):
            hidden[row] = 0.0
            cell[row] = 0.0
            fed[row] = 0.0
            count[row] = 0
            # The alarm may still be held; the next score decides whether it is trusted again.
            distrust[row] = 0
        p = profile[i]
        fill_inputs(inputs, fed[row], curvature_per_m[i], speed_mps[i], camera_sigma_m[i], scale_m[i])
        step_cell(inputs, hidden[row], cell[row], network.weight[p], network.bias[p], gates)
        prediction = network.offset[p]
        for j in range(hidden.shape[1]):
            prediction += network.head[p, j] * hidden[row, j]
        z = residual_m[i] / scale_m[i]
        error = z - prediction
        if push(square, count, row, error * error):
            decide(i, row, mean(square, row), threshold[i], alarm, since_scored, statistic, scored, alarms)
        else:
            hold(i, row, hold_steps, alarm, since_scored, statistic, scored, alarms)
        believed = min(max(z, -CLIP), CLIP)
        if alarm[row]:
            distrust[row] = patience
        if distrust[row] > 0 and abs(z) > abs(prediction):
            believed = prediction
        if distrust[row] > 0 and not alarm[row]:
            distrust[row] -= 1
        fed[row] = believed
