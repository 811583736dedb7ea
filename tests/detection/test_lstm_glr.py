from math import exp

import numpy as np
import pytest
import torch

from gpsec.core.errors import GpsecError
from gpsec.detection import lstm_training
from gpsec.detection.forecast import CLIP, DELAY
from gpsec.detection.logs import Grid
from gpsec.detection.lstm_cell import HIDDEN, INPUTS, exp32
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import DECAYS, LstmGlr
from gpsec.reference.forecast import PlainNetwork
from gpsec.testing.detector_bench import Bench, take
from gpsec.testing.residuals import make_log


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
    detector = LstmGlr((lstm_training.to_arrays(network),))
    bench = Bench(detector, 3)
    state = bench.state.now.forecast
    weights = dict(network.named_parameters())
    cell = torch.nn.LSTMCell(len(INPUTS), HIDDEN)
    with torch.no_grad():
        for key in ("weight_ih", "weight_hh", "bias_ih", "bias_hh"):
            getattr(cell, key).copy_(weights[f"lstm.{key}_l0"])
        for vehicle in range(3):
            memory, past, errors, previous = None, [0.0] * DELAY, [], None
            for t in range(150):
                seen = grid.observe(t)
                one = bench.ask(take(seen, [vehicle]), np.asarray([np.inf]))
                if not grid.valid[t, vehicle]:
                    continue
                if previous is not None and t - previous > 10:
                    memory, past, errors = None, [0.0] * DELAY, []
                previous = t
                z = grid.residual_m[t, vehicle] / 0.3
                inputs = [
                    past[-DELAY],
                    40.0 * grid.curvature_per_m[t, vehicle],
                    12.0 / 20.0,
                    grid.camera_sigma_m[t, vehicle] / 0.3,
                ]
                memory = cell(torch.tensor([inputs], dtype=torch.float32), memory)
                prediction, *log_variances = network.head(memory[0])[0].tolist()
                errors.append(z - prediction)
                expected = [
                    _squared_mean(errors, decay) / exp(v) for decay, v in zip(DECAYS, log_variances, strict=True)
                ]
                assert np.abs(state.hidden[vehicle] - memory[0][0].numpy()).max() < 1e-6
                assert np.abs(state.cell[vehicle] - memory[1][0].numpy()).max() < 2e-6
                assert one.statistic[0] == pytest.approx(max(expected), rel=1e-4, abs=1e-4)
                past.append(min(max(z, -CLIP), CLIP))


def _squared_mean(errors, decay):
    weights = np.asarray([decay**age for age in range(len(errors))][::-1])
    return float((weights @ errors) ** 2 / (weights @ weights))


@pytest.fixture
def level(network):
    """A network that expects 0 with a variance of 1 at every scale, whatever it is told."""
    with torch.no_grad():
        network.head.weight.zero_()
        network.head.bias.zero_()
    return (lstm_training.to_arrays(network),)


def quiet(vehicles=1, steps=60):
    return Grid.of([make_log(vehicles, steps, seed=8, white=0.0, slow=0.0, chord_m=0.0, gaps=False)])


def statistics(detector, grid, threshold):
    bench = Bench(detector, len(grid.length))
    answers = [bench.ask(grid.observe(t), np.full(len(grid.length), threshold)) for t in range(len(grid.valid))]
    return np.asarray([one.statistic for one in answers]), np.asarray([one.alarm for one in answers]), bench.state.now


def test_statistic_by_hand(level):
    grid = quiet()
    grid.residual_m[10:] = 0.3  # one scale
    found, _, _ = statistics(LstmGlr(level), grid, np.inf)
    assert found[9, 0] == 0.0
    # One error of 1: alone it is 1; at the other scales, ten zeros are in the sum of the squared weights as well.
    assert found[10, 0] == pytest.approx(1.0)
    # After many, the square of the sum 1/(1 - λ) over the sum of squares 1/(1 - λ²): (1 + λ)/(1 - λ) at λ = 0.85.
    assert found[59, 0] == pytest.approx(1.85 / 0.15, rel=1e-3)


def test_evidence_ends_when_the_attack_does(level):
    grid = quiet()
    grid.residual_m[10:40] = 0.9
    found, alarm, _ = statistics(LstmGlr(level), grid, 10.0)
    assert alarm[12:40].all()
    # An error of 0 is exp(3²/2) times likelier without an offset of 3 than with it, and exp(3) are enough.
    assert found[40:, 0].tolist() == [0.0] * 20
    stubborn, _, _ = statistics(LstmGlr(level, enough=5.0), grid, 10.0)
    assert stubborn[40, 0] > 10.0


def test_sums_by_hand(level):
    grid = quiet()
    grid.residual_m[10:15] = -0.6  # two scales, on the other side
    found, alarm, _ = statistics(LstmCusum(level, slack=0.75, margin=2.0), grid, 3.0)
    assert found[9:19, 0].tolist() == pytest.approx([0.0, 1.25, 2.5, 3.75, 5.0, 5.75, 3.75, 3.0, 2.25, 1.5])
    assert alarm[:, 0].nonzero()[0].tolist() == [12, 13, 14, 15]


# The statistic of `lstm_glr` is 100 at once; the sums of `lstm_cusum` grow by 6 - 0.5, the fifth is the first over 25.
@pytest.mark.parametrize(("kind", "before_alarm"), [(LstmGlr, 0), (LstmCusum, 4)])
def test_in_alarm_the_network_is_told_its_own_prediction(level, kind, before_alarm):
    grid = quiet(steps=50)
    grid.residual_m[30:] = 3.0  # ten scales
    _, _, state = statistics(kind(level), grid, 25.0)
    # The ring holds what was queued in the last 20 steps: the residual as far as the clip lets it, then the prediction.
    assert sorted(state.forecast.queue[0].tolist()) == [0.0] * (20 - before_alarm) + [CLIP] * before_alarm


def test_a_plausible_residual_is_believed_even_in_alarm(level):
    grid = quiet(steps=50)
    grid.residual_m[20:] = 3.0
    grid.residual_m[40:] = 0.3  # one scale
    _, alarm, state = statistics(LstmCusum(level, margin=20.0), grid, 25.0)
    assert alarm[40:].all()
    assert sorted(state.forecast.queue[0].tolist()) == pytest.approx([0.0] * 10 + [1.0] * 10)


def test_exponential():
    for x in (-80.0, -20.3, -1.0, -1e-6, 0.0, 0.5, 3.25, 40.0, 80.0):
        assert exp32(np.float32(x)) == pytest.approx(exp(np.float32(x)), rel=3e-7)
    assert exp32(np.float32(-1e30)) == exp32(np.float32(-80.0))


def test_training_is_deterministic(monkeypatch):
    monkeypatch.setattr(lstm_training, "EPOCHS", 2)
    logs = [make_log(16, 200, seed=3)]
    first, second, other = (lstm_training.learn_lstm_glr(logs, seed) for seed in (5, 5, 6))
    assert {k: a.tobytes() for k, a in first.items()} == {k: a.tobytes() for k, a in second.items()}
    assert first["weight"].tobytes() != other["weight"].tobytes()


def test_prediction_is_better_than_none_and_knows_how_good_it_is(model):
    # White noise 0.5 on a slow error of 0.8: knowing the past takes most of the latter away.
    grid = Grid.of([make_log(20, 400, seed=21, chord_m=0.0, gaps=False)])
    network = PlainNetwork(model.learned["lstm_glr"])
    errors, expected = [], []
    for vehicle in range(20):
        memory, past = network.blank(), [0.0] * DELAY
        for t in range(400):
            context = [40.0 * grid.curvature_per_m[t, vehicle], 0.6, grid.camera_sigma_m[t, vehicle] / 0.3]
            (prediction, log_variance, *_), memory = network.predict([past[-DELAY], *context], memory)
            z = grid.residual_m[t, vehicle] / 0.3
            past.append(min(max(z, -CLIP), CLIP))
            if t >= 50:
                errors.append((z - prediction) ** 2)
                expected.append(exp(log_variance))
    assert np.mean(errors) < 0.75 * np.mean((grid.residual_m[50:] / 0.3) ** 2)
    assert np.mean(expected) == pytest.approx(np.mean(errors), rel=0.2)


def test_wrong_shape_is_refused(network):
    arrays = dict(lstm_training.to_arrays(network))
    arrays["head"] = arrays["head"][:-1]
    with pytest.raises(GpsecError, match="expected shape"):
        LstmGlr.from_learned([arrays])
