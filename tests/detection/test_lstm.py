"""Eq 10: the mean of the squared errors of a prediction from the residual before."""

from itertools import pairwise

import numpy as np
import pytest
import torch

from gpsec.core.errors import GpsecError
from gpsec.detection import lstm_training
from gpsec.detection.forecast import CLIP
from gpsec.detection.logs import Grid
from gpsec.detection.lstm import Lstm
from gpsec.reference.forecast import PlainNetwork
from gpsec.testing.detector_bench import Bench
from gpsec.testing.residuals import make_log


def _network(scale: float) -> dict[str, np.ndarray]:
    with torch.random.fork_rng():
        torch.manual_seed(11)
        network = lstm_training.ResidualLstm(Lstm.outputs)
        with torch.no_grad():
            network.head.weight.mul_(scale)
            network.head.bias.mul_(scale)
    return dict(lstm_training.to_arrays(network))


def _statistics(detector: Lstm, grid: Grid) -> np.ndarray:
    bench = Bench(detector, len(grid.length))
    threshold = np.full(len(grid.length), np.inf)
    return np.asarray([bench.ask(grid.observe(t), threshold).statistic for t in range(len(grid.valid))])


def test_statistic_by_hand() -> None:
    grid = Grid.of([make_log(1, 20, seed=8, white=0.0, slow=0.0, chord_m=0.0, gaps=False)])
    grid.residual_m[5:, 0] = 0.6  # two scales
    grid.residual_m[10:, 0] = -0.3
    found = _statistics(Lstm((_network(0.0),), window=4), grid)[:, 0]
    # It expects 0. Four are in the mean: 2² once, twice ..., then 1² in their place, whatever their sign.
    assert found[4:15].tolist() == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.25, 2.5, 1.75, 1.0, 1.0])


def test_it_predicts_from_the_residual_before() -> None:
    grid = Grid.of([make_log(1, 60, seed=8, gaps=False)])
    arrays = _network(3.0)
    found = _statistics(Lstm((arrays,)), grid)[:, 0]
    network = PlainNetwork(arrays)
    memory, before, errors = network.blank(), 0.0, []
    for t in range(60):
        context = [40.0 * grid.curvature_per_m[t, 0], 12.0 / 20.0, grid.camera_sigma_m[t, 0] / 0.3]
        (prediction,), memory = network.predict([before, *context], memory)
        z = grid.residual_m[t, 0] / 0.3
        errors.append(z - prediction)
        before = min(max(z, -CLIP), CLIP)
    expected = [(first**2 + second**2) / 2.0 for first, second in pairwise(errors)]
    assert found[1:].tolist() == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_training_takes_most_of_what_is_slow_away() -> None:
    # White noise 0.1 on a slow error of 0.8, in scales: what was seen last says nearly all.
    logs = [make_log(40, 300, seed=seed, white=0.1, slow=0.8, chord_m=0.0, gaps=False) for seed in (3, 4)]
    learned = lstm_training.learn_lstm(logs[:1], 5)
    assert {key: array.shape[-1] for key, array in learned.items()}["head"] == 1
    grid = Grid.of(logs[1:])
    found = _statistics(Lstm((learned,)), grid)[20:]
    assert found.mean() < 0.2 * np.mean((grid.residual_m[20:] / 0.3) ** 2)


def test_a_network_of_more_outputs_is_refused() -> None:
    arrays = _network(1.0) | {"head": np.zeros((32, 4), np.float32)}
    with pytest.raises(GpsecError, match=r"'head' of the LSTM: expected shape \(32, 1\)"):
        Lstm.from_learned([arrays])
