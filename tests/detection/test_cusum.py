from dataclasses import replace
from math import exp, sqrt

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from gpsec.detection import whitening
from gpsec.detection.cusum import Cusum
from gpsec.testing.detector_bench import Bench
from gpsec.testing.residuals import make_log

from .test_chi_square import observe


def plain(**changes):
    return replace(Cusum(white=(1.0,), slow=(1e-9,), tau_s=(30.0,), slack=0.5, clip=4.0, margin=3.0), **changes)


def drive(detector, values, threshold=100.0):
    """Return the statistic and alarm for residuals in units of the scale, which is 0.5 m."""
    bench = Bench(detector, 1)
    verdicts = [bench.ask(observe(0.5 * z), np.asarray([threshold])) for z in values]
    return [float(v.statistic[0]) for v in verdicts], [bool(v.alarm[0]) for v in verdicts], bench.state.now


def test_sums_by_hand_without_a_slow_part():
    # Up: 1.5, 2.0, 0 (2 - 3.5 < 0), 3.5 after clipping 9 to 4; down only at -3: 2.5, then 0.
    statistic, _, _ = drive(plain(), [2.0, 1.0, -3.0, 9.0])
    assert np.allclose(statistic, [1.5, 2.0, 2.5, 3.5], atol=1e-12)


def test_sums_are_two_sided():
    values = [2.0, 3.0, -1.0, 2.5]
    assert drive(plain(), values)[0] == drive(plain(), [-z for z in values])[0]


def test_cap_lets_an_alarm_end():
    # Cap: 5 + 3·0.5 = 6.5; zeros take 0.5 each: 6.0, 5.5, 5.0 is not above 5.
    _, alarm, _ = drive(plain(), [4.0] * 20 + [0.0] * 4, threshold=5.0)
    assert alarm[-4:] == [True, True, False, False]


def test_innovation_is_that_of_a_kalman_filter():
    white, slow, tau_s = 0.6, 0.9, 20.0
    decay = exp(-0.1 / tau_s)
    oracle = KalmanFilter(dim_x=1, dim_z=1)
    oracle.x[:], oracle.P[:], oracle.F[:], oracle.H[:] = 0.0, slow**2, decay, 1.0
    oracle.Q[:], oracle.R[:] = slow**2 * (1.0 - decay**2), white**2
    detector = plain(white=(white,), slow=(slow,), tau_s=(tau_s,), slack=0.0, clip=1e9, reach=1e9)
    values = np.random.default_rng(3).normal(size=50)
    up = down = 0.0
    expected = []
    for z in values:
        oracle.predict()
        oracle.update(z)
        e = oracle.y.item() / sqrt(oracle.S.item())
        up, down = max(0.0, up + e), max(0.0, down - e)
        expected.append(max(up, down))
    assert np.allclose(drive(detector, values, threshold=1e9)[0], expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("threshold", "expected"), [(100.0, 0.5), (4.0, 6.0)])
def test_after_a_gap_the_sums_begin_anew_unless_an_alarm_goes_on(threshold, expected):
    """A sample of 1 less the slack of 0.5, on nothing; or on the cap of 4 + 3·0.5, at which the alarm stood."""
    detector = plain()
    bench = Bench(detector, 1)
    for z in (4.0, 4.0):
        bench.ask(observe(0.5 * z), np.asarray([threshold]))
    for _ in range(11):  # over a second, but no longer than an alarm is held
        bench.ask(observe(0.0, valid=False), np.asarray([threshold]))
    assert bench.ask(observe(0.5, elapsed_steps=12), np.asarray([threshold])).statistic[0] == pytest.approx(expected)


def test_estimate_of_the_slow_part_is_bounded():
    detector = plain(slow=(1.0,), reach=2.0)
    _, _, state = drive(detector, [3.0] * 500, threshold=1e9)
    assert state.level[0] == 2.0


def test_in_alarm_an_implausible_residual_is_not_learned():
    detector = plain(slow=(1.0,))
    _, alarm, state = drive(detector, [0.0] * 50 + [8.0] * 100, threshold=3.0)
    assert all(alarm[50:])
    assert abs(state.level[0]) < 0.1


def test_whitening_finds_the_parameters_of_the_noise():
    log = make_log(80, 900, seed=6, white=0.5, slow=0.8, tau_s=20.0, chord_m=0.0)
    found = whitening.learn_whitening([log], seed=0)
    assert abs(found["white"] - 0.5) < 0.02
    assert abs(found["slow"] - 0.8) < 0.1
    assert 14.0 < found["tau_s"] < 28.0
