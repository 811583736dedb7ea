"""The detectors that forecast the residual, with the LSTM from torch.

The network is float64 here and float32 in the batched engine; that rounding is the difference between the two.
"""

from collections import deque
from collections.abc import Sequence
from math import exp, sqrt
from typing import Self

import numpy as np
import torch
from torch import nn

from gpsec.detection.forecast import CLIP, Forecaster
from gpsec.detection.learned import Learned
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import DECAYS, LstmGlr
from gpsec.reference.detector import Scale, TrackDetector
from gpsec.reference.sight import Sight

NetworkState = tuple[torch.Tensor, torch.Tensor]


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

    def blank(self) -> NetworkState:
        """Return the state before the first input."""
        nothing = torch.zeros(1, self._cell.hidden_size, dtype=torch.float64)
        return nothing, nothing

    def predict(self, inputs: Sequence[float], memory: NetworkState) -> tuple[list[float], NetworkState]:
        """Return the outputs (the prediction, then log-variances) and the memory after one step."""
        with torch.inference_mode():
            after = self._cell(torch.tensor([inputs], dtype=torch.float64), memory)
            outputs: list[float] = self._head(after[0])[0].tolist()
            return outputs, after

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        return self


class TrackForecaster(TrackDetector):
    """Base of the detectors that forecast the residual by the LSTM."""

    def __init__(self, detector: Forecaster, network: PlainNetwork, scale: Scale) -> None:
        super().__init__(scale)
        self._network = network
        self._patience, self._plausible, self._delay = detector.distrust, detector.plausible, detector.delay
        self.forget()

    def forget(self) -> None:
        """Empty the memory."""
        self._memory = self._network.blank()
        self._waiting = deque([0.0] * self._delay)
        self._prediction = 0.0
        self._distrust = 0

    def expect(self, sight: Sight) -> tuple[float, list[float]]:
        """Return the residual that the network expects, and the variance of its error at each scale."""
        inputs = [
            self._waiting.popleft(),
            float(np.clip(40.0 * sight.curvature_per_m, -4.0, 4.0)),
            min(sight.speed_mps / 20.0, 4.0),
            min(sight.camera_sigma_m / self.scale.scale_m, 4.0),
        ]
        (self._prediction, *log_variances), self._memory = self._network.predict(inputs, self._memory)
        return self._prediction, [exp(value) for value in log_variances]

    def learn(self, z: float) -> None:
        """Queue the residual as a later input; in its place the prediction, where a large residual is doubtful."""
        if self.alarm:
            self._distrust = self._patience
        doubtful = self._distrust > 0 and abs(z) > max(abs(self._prediction), self._plausible)
        self._waiting.append(float(np.clip(self._prediction if doubtful else z, -CLIP, CLIP)))
        if not self.alarm:
            self._distrust = max(self._distrust - 1, 0)


class TrackLstm(TrackForecaster):
    """Mean of the last squared errors of an LSTM that predicts the next residual (Eq 10)."""

    def __init__(self, detector: Lstm, network: PlainNetwork, scale: Scale) -> None:
        self._last: deque[float] = deque(maxlen=detector.window)
        super().__init__(detector, network, scale)

    def forget(self) -> None:
        """Empty memory and window."""
        super().forget()
        self._last.clear()

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return ξ = (1/n)·Σ (z - ẑ)²."""
        prediction, _ = self.expect(sight)
        self._last.append((z - prediction) ** 2)
        return float(np.mean(self._last)) if len(self._last) == self._last.maxlen else None


class TrackLstmGlr(TrackForecaster):
    """Generalised likelihood ratio of the errors of an LSTM that predicts the residual, at several time scales."""

    def __init__(self, detector: LstmGlr, network: PlainNetwork, scale: Scale) -> None:
        self._enough = detector.enough
        super().__init__(detector, network, scale)

    def forget(self) -> None:
        """Empty memory and evidence."""
        super().forget()
        self._errors: list[float] = []

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the largest (Σ λʲ·e)² / (Σ λ²ʲ · σ²)."""
        prediction, variances = self.expect(sight)
        error = z - prediction
        if self.alarm and self._errors:
            values, means = zip(*(self._at(decay, v) for decay, v in zip(DECAYS, variances, strict=True)), strict=True)
            offset = means[int(np.argmax(values))]
            if (offset * error - 0.5 * offset**2) / variances[0] < -self._enough:
                self._errors.clear()
        self._errors.append(error)
        return max(self._at(decay, v)[0] for decay, v in zip(DECAYS, variances, strict=True))

    def _at(self, decay: float, variance: float) -> tuple[float, float]:
        """Return the statistic and the mean error at one scale."""
        weights = np.power(decay, np.arange(len(self._errors))[::-1])
        total = float(weights @ self._errors)
        return total**2 / float(weights @ weights) / variance, total * (1.0 - decay)


class TrackLstmCusum(TrackForecaster):
    """Two-sided CUSUM of the errors of the LSTM's prediction."""

    def __init__(self, detector: LstmCusum, network: PlainNetwork, scale: Scale) -> None:
        self._is = detector
        self._up = self._down = 0.0
        super().__init__(detector, network, scale)

    def forget(self) -> None:
        """Empty the memory; an alarm that is held goes on until samples end it."""
        super().forget()
        if not self.alarm:
            self._up = self._down = 0.0

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the larger of the two sums."""
        prediction, variances = self.expect(sight)
        e = float(np.clip((z - prediction) / sqrt(variances[0]), -self._is.clip, self._is.clip))
        # What lasts is in the variance of the weighted sum once for every pair of samples, what does not only once.
        pairs = (1.0 + DECAYS[-1]) / (1.0 - DECAYS[-1])
        lasting = max(variances[-1] - variances[0], 0.0) / (pairs - 1.0)
        slack = self._is.slack + self._is.reach * sqrt(lasting / variances[0])
        up, down = max(0.0, self._up + e - slack), max(0.0, self._down - e - slack)
        cap = self.scale.threshold + self._is.margin * slack
        self._up, self._down = min(up, cap), min(down, cap)
        return max(up, down)
