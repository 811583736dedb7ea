import numpy as np
import pytest

from gpsec.detection.calibration import MIN_EVENTS, replay, thresholds_by_rate
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.logs import Grid
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import LstmGlr
from gpsec.testing.residuals import make_log


def white_log(seed, vehicles=60, steps=900):
    return make_log(vehicles, steps, seed=seed, white=1.0, slow=0.0, chord_m=0.0, gaps=False)


def test_threshold_of_a_normal_deviate():
    # One squared normal deviate is over 10.828 in 0.1 % of all cases.
    found = thresholds_by_rate(ChiSquare(window=1), Grid.of([white_log(1)]), settle_s=0.0)["1e-3/sample"]
    assert found is not None
    # 54 samples are expected over it; their number has a standard deviation of 7.3, which moves it by 0.3.
    assert found.threshold == pytest.approx(10.828, abs=1.2)
    assert found.achieved == pytest.approx(1e-3, rel=0.05)


@pytest.mark.parametrize("name", ["chi_square", "cusum", "lstm", "lstm_glr", "lstm_cusum"])
def test_rate_on_other_data_is_the_one_asked_for(name, model):
    detector = {
        "chi_square": lambda: ChiSquare(),
        "cusum": lambda: Cusum.from_learned([model.learned["cusum"]]),
        "lstm": lambda: Lstm.from_learned([model.learned["lstm"]]),
        "lstm_glr": lambda: LstmGlr.from_learned([model.learned["lstm_glr"]]),
        "lstm_cusum": lambda: LstmCusum.from_learned([model.learned["lstm_glr"]]),
    }[name]()
    # Short correlation, so that there are many independent samples in little data.
    logs = [make_log(100, 700, seed=seed, tau_s=3.0, chord_m=0.0, gaps=False) for seed in (31, 32)]
    found = thresholds_by_rate(detector, Grid.of(logs[:1]))["1e-3/sample"]
    assert found is not None
    assert found.achieved == pytest.approx(1e-3, rel=0.25)
    held_out = replay(detector, Grid.of(logs[1:]), found.threshold, settle_s=10.0)
    assert 0.4e-3 < held_out.alarmed / held_out.scored < 2.2e-3
    # Only vehicles that may be in alarm are replayed to find the threshold; all of them together have that rate.
    whole = replay(detector, Grid.of(logs[:1]), found.threshold, settle_s=10.0)
    assert whole.alarmed / whole.scored == found.achieved


def test_too_little_data_is_not_extrapolated():
    found = thresholds_by_rate(ChiSquare(window=1), Grid.of([white_log(1)]), settle_s=0.0)
    # 54,000 samples and 1.5 vehicle-hours: 5.4 alarmed samples at 1e-4, 1.5 alarms at 1/h.
    assert MIN_EVENTS > 5.4
    assert [name for name, value in found.items() if value is None] == [
        "1e-4/sample",
        "1/h",
        "0.1/h",
        "0.01/h",
        "1e-3/h",
    ]


def test_alarms_per_hour():
    detector = ChiSquare(window=1)
    log = white_log(2, vehicles=400, steps=960)  # 10.7 vehicle-hours
    found = thresholds_by_rate(detector, Grid.of([log]), settle_s=0.0)["1/h"]
    assert found is not None
    statistic = (log.residual_m / 0.3) ** 2
    over = (statistic > found.threshold).reshape(400, 960)
    onsets = int((over[:, 1:] & ~over[:, :-1]).sum() + over[:, 0].sum())
    assert found.achieved == pytest.approx(onsets / (400 * 96.0 / 3600.0), abs=1e-9)
    assert found.achieved == pytest.approx(1.0, rel=0.1)


def test_replay_counts_by_hand():
    log = white_log(3, vehicles=2, steps=40)
    values = np.zeros((2, 40))
    values[0, [5, 20, 21]] = 10.0  # the first is before settling
    values[1, [30]] = 10.0
    log.residual_m[:] = 0.3 * values.ravel()
    low, high = (replay(ChiSquare(window=1), Grid.of([log]), threshold, settle_s=1.0) for threshold in (50.0, 200.0))
    assert (low.scored, low.alarmed, low.onsets) == (60, 3, 2)
    assert (high.scored, high.alarmed, high.onsets) == (60, 0, 0)
    assert low.hours == pytest.approx(6.0 / 3600.0)
    assert low.peak.tolist() == pytest.approx([100.0, 100.0])
    assert np.sort(low.statistic)[-4:].tolist() == pytest.approx([0.0, 100.0, 100.0, 100.0])
