"""One step of a small LSTM with a linear head, for rows of several sensor profiles at once, in float32.

Weights of all profiles lie in one array, so a batch may mix them. Every row is computed on its own in a fixed order of
operations without fused multiply-add, so its bits depend neither on the batch nor on the number of threads, and, as
the exponential below is made of exactly rounded operations, not on the processor either.
"""

import numpy as np

from gpsec.arrays import Floats32
from gpsec.kernels import inline

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
def sigmoid32(x: np.float32) -> np.float32:
    """Return 1 / (1 + e**-x)."""
    return _ONE / (_ONE + exp32(-x))


@inline
def _accumulate(gates: Floats32, weight: Floats32, vector: Floats32) -> None:
    """Add vector @ weight to gates, four terms at a time so that the sums stay in registers."""
    for k in range(0, len(vector), 4):
        a, b, c, d = vector[k], vector[k + 1], vector[k + 2], vector[k + 3]
        for j in range(len(gates)):
            gates[j] = (((gates[j] + weight[k, j] * a) + weight[k + 1, j] * b) + weight[k + 2, j] * c) + weight[
                k + 3, j
            ] * d


@inline
def step_cell(
    inputs: Floats32,
    hidden: Floats32,
    cell: Floats32,
    weight: Floats32,
    bias: Floats32,
    gates: Floats32,
) -> None:
    """Advance one row: Hochreiter and Schmidhuber's LSTM with forget gate, gates in torch's order i, f, g, o.

    Args:
        inputs: (K,) of this step; K and H are multiples of 4.
        hidden: (H,) state, overwritten.
        cell: (H,) state, overwritten.
        weight: (K + H, 4H) of inputs, then hidden.
        bias: (4H,).
        gates: (4H,) scratch.
    """
    size = len(hidden)
    for j in range(4 * size):
        gates[j] = bias[j]
    _accumulate(gates, weight[: len(inputs)], inputs)
    _accumulate(gates, weight[len(inputs) :], hidden)
    # tanh(x) = 2·sigmoid(2x) - 1 lets one loop serve all gates.
    for j in range(2 * size, 3 * size):
        gates[j] *= _TWO
    for j in range(4 * size):
        gates[j] = sigmoid32(gates[j])
    for j in range(size):
        candidate = _TWO * gates[2 * size + j] - _ONE
        cell[j] = gates[size + j] * cell[j] + gates[j] * candidate
    for j in range(size):
        hidden[j] = gates[3 * size + j] * (_TWO * sigmoid32(_TWO * cell[j]) - _ONE)
