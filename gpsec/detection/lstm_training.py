"""Trains the LSTMs with torch on benign residuals: the one of Eq 10, and the one that says how far off it may be."""

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import nn

from gpsec.core.arrays import Floats, Floats32
from gpsec.core.errors import GpsecError
from gpsec.detection.alarm import GAP_S, steps_in
from gpsec.detection.forecast import CLIP, DELAY
from gpsec.detection.learned import Learned, OnStage, silent
from gpsec.detection.logs import Grid, ResidualLog, sessions, split
from gpsec.detection.lstm_cell import HIDDEN, INPUTS, OUTPUTS
from gpsec.detection.lstm_glr import DECAYS

LENGTH = 256
BATCH = 32
EPOCHS = 12
PATIENCE = 4
LEARNING_RATE = 4e-3
HELD_OUT = 0.15
MAX_LSTM_WINDOWS = 1800
# A match to the wrong lane may be a dozen scales off; it shall not steer the training.
TARGET_CLIP = 5.0


class ResidualLstm(nn.Module):
    """Predicts each residual of a sequence from those before it and, with more outputs, how far off it may be."""

    def __init__(self, outputs: int = OUTPUTS) -> None:
        super().__init__()
        self.lstm = nn.LSTM(len(INPUTS), HIDDEN, batch_first=True)
        self.head = nn.Linear(HIDDEN, outputs)

    def forward(self, inputs: torch.Tensor) -> torch.Tensor:
        """Return (b, t, Q) predictions and log-variances of (b, t, K) inputs, beginning with an empty memory."""
        hidden, _ = self.lstm(inputs)
        outputs: torch.Tensor = self.head(hidden)
        return outputs


@dataclass(frozen=True)
class Sequences:
    """Training windows: inputs (w, L, K), the residual to predict (w, L), and weight (w, L), 0 in the padding."""

    inputs: torch.Tensor
    target: torch.Tensor
    weight: torch.Tensor

    def __len__(self) -> int:
        return len(self.inputs)

    def batches(self, order: torch.Tensor) -> Iterator["Sequences"]:
        """Yield the windows of `order`, `BATCH` at a time."""
        for chosen in torch.split(order, BATCH):
            yield Sequences(self.inputs[chosen], self.target[chosen], self.weight[chosen])


# What a batch costs: a sum over its samples, and their number.
Loss = Callable[[ResidualLstm, Sequences], tuple[torch.Tensor, torch.Tensor]]


def learn_lstm(logs: Sequence[ResidualLog], seed: int, progress: OnStage = silent) -> Learned:
    """Return the arrays of a network that predicts each residual from those up to the one before it, for `lstm`.

    The mean squared error is what it learns by, as it is what Eq 10 looks at; see `learn_lstm_glr` for the rest.

    Raises:
        GpsecError: there are too few sequences to hold some out.
    """
    return _learn(logs, seed, (1, 1, _squared_error), progress)


def learn_lstm_glr(logs: Sequence[ResidualLog], seed: int, progress: OnStage = silent) -> Learned:
    """Return the arrays of a network that was fitted to benign residuals, for `lstm_glr`; see `lstm_cell.Network`.

    Adam on the negative log-likelihood, with a cosine schedule; the epoch that is best on held-out vehicles is kept.
    One thread, so that the result depends on `seed` alone.

    Raises:
        GpsecError: there are too few sequences to hold some out.
    """
    weights = averaging(LENGTH)
    return _learn(logs, seed, (DELAY, OUTPUTS, lambda model, batch: _loss(model, batch, weights)), progress)


def _learn(logs: Sequence[ResidualLog], seed: int, recipe: tuple[int, int, Loss], progress: OnStage) -> Learned:
    """Return the arrays of a network of a recipe: samples of delay, outputs, and the loss."""
    delay, outputs, loss = recipe
    held_out, fitted = split(logs, HELD_OUT, seed)
    train, check = _sequences(fitted, seed, delay), _sequences(held_out, seed, delay)
    if not (len(train) and len(check)):
        raise GpsecError(f"residual logs of profile '{logs[0].profile}': too few vehicles to train the LSTM")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            return to_arrays(_fit(ResidualLstm(outputs), loss, (train, check), progress))
    finally:
        torch.set_num_threads(threads)


def to_arrays(model: ResidualLstm) -> Learned:
    """Return the weights of a network as the kernel reads them."""
    weights = {name: value.detach().numpy() for name, value in model.named_parameters()}
    both = np.concatenate([weights["lstm.weight_ih_l0"].T, weights["lstm.weight_hh_l0"].T])
    return {
        "weight": np.ascontiguousarray(both, np.float32),
        "bias": weights["lstm.bias_ih_l0"] + weights["lstm.bias_hh_l0"],
        "head": np.ascontiguousarray(weights["head.weight"].T),
        "offset": weights["head.bias"].copy(),
    }


def _sequences(logs: Sequence[ResidualLog], seed: int, delay: int) -> Sequences:
    if not any(len(log.vehicle) for log in logs):
        return Sequences(torch.zeros(0, LENGTH, len(INPUTS)), torch.zeros(0, LENGTH), torch.zeros(0, LENGTH))
    grid = Grid.of(logs)
    inputs: list[Floats32] = []
    targets: list[Floats32] = []
    for vehicle, steps in sessions(grid, steps_in(GAP_S, grid.step_s)):
        scale = grid.scale_m[vehicle]
        residual = np.clip(grid.residual_m[steps, vehicle] / scale, -TARGET_CLIP, TARGET_CLIP)
        columns = [
            np.clip(np.concatenate([np.zeros(delay), residual])[: len(residual)], -CLIP, CLIP),
            np.clip(40.0 * grid.curvature_per_m[steps, vehicle], -4.0, 4.0),
            np.minimum(0.05 * grid.speed_mps[steps, vehicle], 4.0),
            np.minimum(grid.camera_sigma_m[steps, vehicle] / scale, 4.0),
        ]
        table = np.stack(columns, axis=1).astype(np.float32)
        for first in range(0, len(steps), LENGTH):
            inputs.append(table[first : first + LENGTH])
            targets.append(residual[first : first + LENGTH].astype(np.float32))
    order = np.random.default_rng(seed).permutation(len(inputs))[:MAX_LSTM_WINDOWS]
    padded = np.zeros((len(order), LENGTH, len(INPUTS)), np.float32)
    target, weight = np.zeros(padded.shape[:2], np.float32), np.zeros(padded.shape[:2], np.float32)
    for row, source in enumerate(order):
        size = len(targets[source])
        padded[row, :size], target[row, :size], weight[row, :size] = inputs[source], targets[source], 1.0
    return Sequences(torch.from_numpy(padded), torch.from_numpy(target), torch.from_numpy(weight))


def averaging(length: int) -> torch.Tensor:
    """Return (S, length, length) weights of errors, the columns, in the mean at each step, the rows, as in `LstmGlr`.

    They are scaled such that white noise keeps its variance.
    """
    age = np.arange(length)[:, None] - np.arange(length)[None, :]
    scales: list[Floats] = []
    for decay in DECAYS:
        weight = np.where(age >= 0, np.power(decay, np.maximum(age, 0)), 0.0)
        scales.append(weight / np.sqrt((weight * weight).sum(axis=1, keepdims=True)))
    return torch.from_numpy(np.stack(scales).astype(np.float32))


def _loss(model: ResidualLstm, batch: Sequences, weights: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the summed negative log-likelihood of the errors at every scale, and the number of samples.

    The prediction is learned from single errors alone. From means over many, it would learn to make errors that cancel
    those before.
    """
    output = model(batch.inputs)
    error = (batch.target - output[..., 0]) * batch.weight
    loss = torch.zeros_like(error)
    for scale, weight in enumerate(weights):
        mean = error if DECAYS[scale] == 0.0 else error.detach() @ weight.T
        log_variance = output[..., 1 + scale]
        loss = loss + 0.5 * (mean * mean * torch.exp(-log_variance) + log_variance)
    return (loss * batch.weight).sum(), batch.weight.sum()


def _squared_error(model: ResidualLstm, batch: Sequences) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the summed squared error of the predictions, and the number of samples."""
    error = (batch.target - model(batch.inputs)[..., 0]) * batch.weight
    return (error * error).sum(), batch.weight.sum()


def _fit(model: ResidualLstm, loss_of: Loss, sets: tuple[Sequences, Sequences], progress: OnStage) -> ResidualLstm:
    """Return the network as it was after the epoch that is best on the second of two sets, learning from the first."""
    train, check = sets
    best, best_loss, stale = copy.deepcopy(model), float("inf"), 0
    optimizer = torch.optim.Adam(model.parameters(), lr=LEARNING_RATE)
    batches = -(-len(train) // BATCH)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, EPOCHS * batches)
    for epoch in range(EPOCHS):
        progress("training lstm", epoch, EPOCHS)
        model.train()
        for batch in train.batches(torch.randperm(len(train))):
            total, count = loss_of(model, batch)
            optimizer.zero_grad()
            (total / count).backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(model.parameters(), 1.0)
            optimizer.step()
            schedule.step()
        model.eval()
        with torch.inference_mode():
            losses = [loss_of(model, batch) for batch in check.batches(torch.arange(len(check)))]
        loss = float(sum(total for total, _ in losses)) / float(sum(count for _, count in losses))
        if loss < best_loss - 1e-5:
            best, best_loss, stale = copy.deepcopy(model), loss, 0
        else:
            stale += 1
            if stale == PATIENCE:
                break
    progress("training lstm", EPOCHS, EPOCHS)
    return best
