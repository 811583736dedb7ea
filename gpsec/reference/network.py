"""The LSTM from torch, in float64: the batched one is float32, and its rounding is what is left between the two."""

from collections.abc import Sequence
from typing import Self

import numpy as np
import torch
from torch import nn

from gpsec.detection.learned import Learned

Memory = tuple[torch.Tensor, torch.Tensor]


class PlainNetwork:
    """A torch cell with linear heads; shared by all tracks."""

    def __init__(self, learned: Learned) -> None:
        weight, bias = learned["weight"], learned["bias"]
        hidden, outputs = learned["head"].shape
        inputs = len(weight) - hidden
        self._cell = nn.LSTMCell(inputs, hidden, dtype=torch.float64)
        self._head = nn.Linear(hidden, outputs, dtype=torch.float64)
        values = {
            self._cell.weight_ih: weight[:inputs].T,
            self._cell.weight_hh: weight[inputs:].T,
            self._cell.bias_ih: bias,
            self._cell.bias_hh: np.zeros_like(bias),
            self._head.weight: learned["head"].T,
            self._head.bias: learned["offset"],
        }
        with torch.no_grad():
            for parameter, value in values.items():
                parameter.copy_(torch.from_numpy(np.ascontiguousarray(value, np.float64)))

    def blank(self) -> Memory:
        """Return the memory of one that has seen nothing."""
        nothing = torch.zeros(1, self._cell.hidden_size, dtype=torch.float64)
        return nothing, nothing

    def predict(self, inputs: Sequence[float], memory: Memory) -> tuple[list[float], Memory]:
        """Return the outputs (the prediction, then log-variances) and the memory after one step."""
        with torch.inference_mode():
            after = self._cell(torch.tensor([inputs], dtype=torch.float64), memory)
            outputs: list[float] = self._head(after[0])[0].tolist()
            return outputs, after

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        return self
