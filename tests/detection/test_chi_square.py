import numpy as np

from gpsec.detection.base import Observation
from gpsec.detection.channels import silent_channels
from gpsec.detection.chi_square import ChiSquare
from gpsec.testing.detector_bench import Bench


def observe(residual_m, valid=True, elapsed_steps=1):
    one = np.ones(1)
    return Observation(
        rows=np.zeros(1, np.int32),
        profile=np.zeros(1, np.int32),
        residual_m=residual_m * one,
        valid=np.asarray([valid]),
        elapsed_steps=np.asarray([elapsed_steps], np.int32),
        scale_m=0.5 * one,
        speed_mps=10.0 * one,
        curvature_per_m=0.0 * one,
        camera_sigma_m=0.05 * one,
        channels=silent_channels((1,)),
        step_s=0.1,
        unmatched=np.zeros(1, np.bool_),
    )


def test_statistic_is_the_mean_square_of_the_last_three():
    detector = ChiSquare(window=3)
    bench = Bench(detector, 1)
    verdicts = [bench.ask(observe(z), np.asarray([5.0])) for z in (0.5, -1.0, 1.5, 0.0)]
    # Normalised: 1, -2, 3, 0.
    assert [bool(v.scored[0]) for v in verdicts] == [False, False, True, True]
    assert verdicts[2].statistic[0] == (1.0 + 4.0 + 9.0) / 3.0
    assert verdicts[3].statistic[0] == (4.0 + 9.0 + 0.0) / 3.0
    assert not verdicts[2].alarm[0]


def test_alarm_needs_more_than_the_threshold():
    detector = ChiSquare(window=1)
    for threshold, expected in ((4.0, False), (3.999, True)):
        verdict = Bench(detector, 1).ask(observe(-1.0), np.asarray([threshold]))
        assert bool(verdict.alarm[0]) is expected


def test_white_residuals_have_a_chi_square_distribution():
    # The mean of n squares of unit deviates has mean 1 and variance 2/n.
    detector = ChiSquare(window=4)
    bench = Bench(detector, 1)
    draws = np.random.default_rng(1).normal(size=8000)
    values = [bench.ask(observe(0.5 * z), np.asarray([9.0])).statistic[0] for z in draws][3::4]
    assert abs(np.mean(values) - 1.0) < 4.0 * np.sqrt(2.0 / 8000)
    assert abs(np.var(values) - 0.5) < 0.1
