from math import exp

import numpy as np
import pytest
import torch

from gpsec.detection import lstm_training
from gpsec.detection.logs import Grid
from gpsec.detection.lstm import CLIP, Lstm
from gpsec.detection.lstm_cell import HIDDEN, INPUTS, exp32
from gpsec.errors import GpsecError

from .ask import ask
from .synthetic import make_log


@pytest.fixture
def network():
    with torch.random.fork_rng():
        torch.manual_seed(11)
        net = lstm_training.ResidualLstm()
        with torch.no_grad():
            for value in net.parameters():
                value.mul_(3.0)  # well into the bends of the gates
        return net


def test_every_step_equals_torch(network):
    grid = Grid.of([make_log(3, 150, seed=8)])
    detector = Lstm((lstm_training.to_arrays(network),), window=1)
    state = detector.new_state(3)
    weights = dict(network.named_parameters())
    cell = torch.nn.LSTMCell(len(INPUTS), HIDDEN)
    with torch.no_grad():
        for key in ("weight_ih", "weight_hh", "bias_ih", "bias_hh"):
            getattr(cell, key).copy_(weights[f"lstm.{key}_l0"])
        for vehicle in range(3):
            memory, last, previous = None, 0.0, None
            for t in range(150):
                seen = grid.observe(t)
                one = ask(detector, state, _one(seen, vehicle), np.asarray([np.inf]))
                if not grid.valid[t, vehicle]:
                    continue
                if previous is not None and t - previous > 10:
                    memory, last = None, 0.0
                previous = t
                z = grid.residual_m[t, vehicle] / 0.3
                inputs = [
                    last,
                    40.0 * grid.curvature_per_m[t, vehicle],
                    12.0 / 20.0,
                    grid.camera_sigma_m[t, vehicle] / 0.3,
                ]
                memory = cell(torch.tensor([inputs], dtype=torch.float32), memory)
                prediction = float(network.head(memory[0])[0, 0])
                assert np.abs(state.hidden[vehicle] - memory[0][0].numpy()).max() < 1e-6
                assert np.abs(state.cell[vehicle] - memory[1][0].numpy()).max() < 2e-6
                assert one.statistic[0] == pytest.approx((z - prediction) ** 2, abs=1e-5 * (1.0 + abs(z)))
                last = min(max(z, -CLIP), CLIP)


def _one(seen, row):
    names = ("rows", "profile", "residual_m", "valid", "scale_m", "speed_mps", "curvature_per_m", "camera_sigma_m")
    fields = {name: getattr(seen, name)[row : row + 1] for name in names}
    return type(seen)(**fields, step_s=seen.step_s)


def test_in_alarm_it_is_fed_its_own_prediction(network):
    grid = Grid.of([make_log(1, 60, seed=8, white=0.0, slow=0.0, chord_m=0.0, gaps=False)])
    detector = Lstm((lstm_training.to_arrays(network),), window=1, distrust=2)
    grid.residual_m[30:40] = 3.0
    state = detector.new_state(1)
    fed = []
    for t in range(60):
        verdict = ask(detector, state, grid.observe(t), np.asarray([25.0]))
        assert bool(verdict.alarm[0]) == (30 <= t < 40)
        fed.append(float(state.fed[0]))
    # Normalised, the bias is 10: it would be fed as the clip.
    assert max(abs(f) for f in fed[30:40]) < CLIP
    assert fed[40:] == [0.0] * 20


def test_exponential():
    for x in (-80.0, -20.3, -1.0, -1e-6, 0.0, 0.5, 3.25, 40.0, 80.0):
        assert exp32(np.float32(x)) == pytest.approx(exp(np.float32(x)), rel=3e-7)
    assert exp32(np.float32(-1e30)) == exp32(np.float32(-80.0))


def test_training_is_deterministic(monkeypatch):
    monkeypatch.setattr(lstm_training, "EPOCHS", 2)
    logs = [make_log(16, 200, seed=3)]
    first, second, other = (lstm_training.learn(logs, seed) for seed in (5, 5, 6))
    assert {k: a.tobytes() for k, a in first.items()} == {k: a.tobytes() for k, a in second.items()}
    assert first["weight"].tobytes() != other["weight"].tobytes()


def test_prediction_is_better_than_none(model):
    # White noise 0.5 on a slow error of 0.8: knowing the past takes most of the latter away.
    grid = Grid.of([make_log(20, 400, seed=21, chord_m=0.0, gaps=False)])
    detector = Lstm.from_learned([model.learned["lstm"]])
    state = detector.new_state(20)
    errors = [ask(detector, state, grid.observe(t), np.full(20, np.inf)).statistic for t in range(400)]
    assert np.mean(errors[50:]) < 0.75 * np.mean((grid.residual_m[50:] / 0.3) ** 2)


def test_wrong_shape_is_refused(network):
    arrays = dict(lstm_training.to_arrays(network))
    arrays["head"] = arrays["head"][:-1]
    with pytest.raises(GpsecError, match="expected shape"):
        Lstm.from_learned([arrays])
