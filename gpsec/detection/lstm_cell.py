"""One step of a small LSTM with linear heads, for rows of several sensor profiles at once, in float32.

Weights of all profiles lie in one array, so a batch may mix them. Every row is computed on its own in a fixed order of
operations without fused multiply-add, so its bits depend neither on the batch nor on the number of threads, and, as
the exponential below is made of exactly rounded operations, not on the processor either.

A block of rows takes each stage of the step together: a sigmoid is a long chain of operations, and a processor is only
busy where it has many of them to do.
"""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats32, Ints
from gpsec.core.kernels import inline

HIDDEN = 32
# What the network is told in a step; a multiple of 4, as is HIDDEN.
INPUTS = ("delayed residual", "curvature", "speed", "camera sigma")
# What it says: the residual that it expects, and the logarithm of the variance of its error, for each time scale.
SCALES = 3
OUTPUTS = 1 + SCALES
# Rows that take a step together.
CELL_BLOCK = 64
GATES = 4 * HIDDEN
_K = len(INPUTS)

_LOG2_E = np.float32(1.4426950408889634)
# ln 2 in two parts: the first has few enough bits that its product with a small integer is exact.
_LN2_HIGH = np.float32(0.693359375)
_LN2_LOW = np.float32(-2.12194440e-4)
# Adding and subtracting 1.5·2**23 rounds a float32 to the nearest integer.
_ROUND = np.float32(12582912.0)
_LIMIT = np.float32(80.0)
_ONE, _TWO, _HALF = np.float32(1.0), np.float32(2.0), np.float32(0.5)
_C3, _C4, _C5, _C6 = np.float32(1 / 6), np.float32(1 / 24), np.float32(1 / 120), np.float32(1 / 720)
_C7 = np.float32(1 / 5040)
_MANTISSA = np.int32(23)


@inline
def exp32(x: np.float32) -> np.float32:
    """Return e**x, for x clamped to [-80, 80], with a relative error of 3e-7 (2**n times a Taylor polynomial)."""
    x = min(max(x, -_LIMIT), _LIMIT)
    shifted = x * _LOG2_E + _ROUND  # its lowest bits are the integer n
    n = shifted - _ROUND
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    p = _C6 + r * _C7
    p = _C5 + r * p
    p = _C4 + r * p
    p = _C3 + r * p
    p = _HALF + r * p
    p = _ONE + r * p
    p = _ONE + r * p
    # n is added to the exponent of p.
    exponent = np.int32(np.float32(shifted).view(np.int32) << _MANTISSA)
    return np.int32(np.float32(p).view(np.int32) + exponent).view(np.float32)


@inline
def falling32(x: np.float32) -> np.float32:
    """Return 1 / (1 + e**x): the sigmoid of -x."""
    return _ONE / (_ONE + exp32(x))


def for_falling(gates: Floats32) -> None:
    """Make weights or biases (…, 4H) such that all gates are `falling32` of their sum.

    They change sign, and those of g are doubled besides, since tanh(x) = 2·sigmoid(2x) - 1. Neither touches a digit.
    """
    gates *= -_ONE
    gates[..., 2 * HIDDEN : 3 * HIDDEN] *= _TWO


class Network(NamedTuple):
    """The weights of P profiles, for K inputs and H hidden units.

    Attributes:
        weight: (P, K + H, 4H) of inputs, then hidden units, gates in torch's order i, f, g, o; see `for_falling`.
        bias: (P, 4H), likewise.
        head: (P, H, 1 + S) of the prediction, and of the log-variances.
        offset: (P, 1 + S) likewise.
    """

    weight: Floats32
    bias: Floats32
    head: Floats32
    offset: Floats32


class Step(NamedTuple):
    """Up to `CELL_BLOCK` rows that take a step.

    Attributes:
        row: (CELL_BLOCK,) of the state.
        inputs: (CELL_BLOCK, K + H) of the network, the last H being its hidden units.
        gates: (CELL_BLOCK, 4H) scratch.
        bent: (CELL_BLOCK, H) scratch.
        output: (CELL_BLOCK, 1 + S) result: the prediction, and one over the variance of its error at each of S scales.
    """

    row: Ints
    inputs: Floats32
    gates: Floats32
    bent: Floats32
    output: Floats32


@inline
def _sum_gates(step: Step, count: int, network: Network, profile: int) -> None:
    """Set gates to bias + inputs @ weight, four terms at a time so that the sums stay in registers."""
    gates, inputs, weight = step.gates, step.inputs, network.weight
    for n in range(count):
        for j in range(GATES):
            gates[n, j] = network.bias[profile, j]
        for k in range(0, _K + HIDDEN, 4):
            a, b, c, d = inputs[n, k], inputs[n, k + 1], inputs[n, k + 2], inputs[n, k + 3]
            for j in range(GATES):
                gates[n, j] = (
                    ((gates[n, j] + weight[profile, k, j] * a) + weight[profile, k + 1, j] * b)
                    + weight[profile, k + 2, j] * c
                ) + weight[profile, k + 3, j] * d


@inline
def take_step(step: Step, count: int, network: Network, profile: int, hidden: Floats32, cell: Floats32) -> None:
    """Let the first `count` rows of a block take a step: Hochreiter and Schmidhuber's LSTM with forget gate.

    Args:
        step: rows and the first K inputs are given; the output is filled in.
        count: how many of them.
        network: of all profiles.
        profile: that of all these rows.
        hidden: (M, H) state, overwritten.
        cell: (M, H) state, overwritten.
    """
    gates, bent = step.gates, step.bent
    for n in range(count):
        row = step.row[n]
        for j in range(HIDDEN):
            step.inputs[n, _K + j] = hidden[row, j]
    _sum_gates(step, count, network, profile)
    for n in range(count):
        for j in range(GATES):
            gates[n, j] = falling32(gates[n, j])
    for n in range(count):
        row = step.row[n]
        for j in range(HIDDEN):
            candidate = _TWO * gates[n, 2 * HIDDEN + j] - _ONE
            kept = gates[n, HIDDEN + j] * cell[row, j] + gates[n, j] * candidate
            cell[row, j] = kept
            bent[n, j] = -_TWO * kept
    for n in range(count):
        for j in range(HIDDEN):
            bent[n, j] = falling32(bent[n, j])
    for n in range(count):
        row = step.row[n]
        for j in range(HIDDEN):
            hidden[row, j] = gates[n, 3 * HIDDEN + j] * (_TWO * bent[n, j] - _ONE)
        for q in range(OUTPUTS):
            step.output[n, q] = network.offset[profile, q]
        for j in range(HIDDEN):
            for q in range(OUTPUTS):
                step.output[n, q] += network.head[profile, j, q] * hidden[row, j]
    for n in range(count):
        for q in range(1, OUTPUTS):
            step.output[n, q] = exp32(-step.output[n, q])
