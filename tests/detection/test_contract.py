"""What holds for every registered detector; the rules are in `gpsec.testing`."""

from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
import pytest
from sklearn.svm import OneClassSVM

from gpsec.core.tables import Table
from gpsec.detection.base import LabelledDetector
from gpsec.detection.bounds import Told
from gpsec.detection.models import build_detectors, thresholds_for
from gpsec.detection.plain import WindowDetector
from gpsec.detection.registry import DETECTORS
from gpsec.testing import DETECTOR_CHECKS, BrokenContractError, check_detector
from gpsec.testing.detector_bench import CASE_PROFILES, DetectorCase
from gpsec.testing.detectors import a_long_gap_forgets_and_a_short_one_does_not, an_alarm_ends_soon_after_the_attack
from gpsec.testing.residuals import benign, spoofed
from gpsec.types.answers import Answers

NAMES = [name for name in DETECTORS if name != Told.name]
# Sums stay at 0 below their slack, which is larger where the network expects errors that last.
SLACK = {"lstm_cusum": 1.5}
OF_ALARMS = [check for check in DETECTOR_CHECKS if "alarm" in check.__name__ or "bias" in check.__name__]


@pytest.fixture(scope="module")
def models(model):
    # What the second profile's vehicles learned differs a little.
    forest, networks = model.learned["isolation_forest"], {name: model.learned[name] for name in ("lstm", "lstm_glr")}
    other = {
        "cusum": {**model.learned["cusum"], "white": np.asarray(0.7)},
        "isolation_forest": {**forest, "threshold": np.float32(0.9) * forest["threshold"]},
        **{name: {**one, "weight": np.float32(0.9) * one["weight"]} for name, one in networks.items()},
    }
    return {("first", "tracked"): model, ("second", "tracked"): replace(model, learned=other)}


def case_of(name, models) -> DetectorCase:
    threshold = float(thresholds_for([(name, "1e-3/sample")], ["first"], "tracked", models)[0, 0])

    def build(profiles):
        (detector,) = build_detectors([name], profiles, "tracked", models)
        return detector

    return DetectorCase(build, threshold, SLACK.get(name, 1.0))


@pytest.mark.parametrize("check", DETECTOR_CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", NAMES)
def test_it_keeps_the_contract(name, check, models):
    if name == "never" and check in OF_ALARMS:
        with pytest.raises(BrokenContractError):  # it never raises one
            check(replace(case_of(name, models), threshold=-1.0))
        return
    check(case_of(name, models))


def test_told_is_told_the_truth():
    (told,) = build_detectors(["told"], CASE_PROFILES, "tracked", {})
    assert isinstance(told, LabelledDetector)
    attacked = np.asarray([True, False, True])
    rows = np.asarray([2, 0, 3], np.int32)
    answers = Table(Answers, 4, detectors=2, defences=0).now
    told.update(rows, attacked, answers, 1)
    assert answers.alarm[rows, 1].tolist() == [True, False, True]
    assert answers.statistic[rows, 1].tolist() == [1.0, 0.0, 1.0]
    assert answers.scored[rows, 1].all()
    assert not any(column[1, 1] or column[:, 0].any() for column in answers[:3])


def test_never_is_silent(models):
    grid = benign()
    _, scored, alarm = case_of("never", models).run(spoofed(grid, 10, 5.0))
    assert not alarm.any()
    assert np.array_equal(scored, grid.valid)


class Mean(WindowDetector):
    """Squared mean of a window."""

    name: ClassVar[str] = "mean"
    samples: ClassVar[int] = 4

    def score(self, windows, profile):
        first, second, third, fourth = windows.T
        return ((first + second + third + fourth) / 4.0) ** 2


class Whole(WindowDetector):
    """Mean square of the residual and of what the monitor whitens."""

    name: ClassVar[str] = "whole"
    samples: ClassVar[int] = 2
    channels: ClassVar[tuple[str, ...]] = ("along", "across", "camera")

    def score(self, windows, profile):
        assert windows.shape == (len(profile), 2, 4)
        return (windows**2).sum(axis=(1, 2)) / 8.0


class Support(WindowDetector):
    """How far a window is outside of what scikit-learn's one-class SVM has seen."""

    name: ClassVar[str] = "support"
    samples: ClassVar[int] = 3

    def __init__(self) -> None:
        windows = np.random.default_rng(1).normal(0.0, 1.0, (300, self.samples))
        self.machine = OneClassSVM(nu=0.05, gamma=0.01).fit(windows)

    def score(self, windows, profile):
        one_by_one = [self.machine.decision_function(window[np.newaxis])[0] for window in np.clip(windows, -40.0, 40.0)]
        return np.maximum(10.0 - np.array(one_by_one, np.float64), 0.0)


def test_a_detector_in_plain_numpy_and_one_of_scikit_learn_keep_the_contract():
    check_detector(lambda profiles: Mean(), threshold=4.0)
    assert Whole.reads_monitor
    assert not Mean.reads_monitor
    check_detector(lambda profiles: Whole(), threshold=4.0)
    support = DetectorCase(lambda profiles: Support(), threshold=11.0)
    for check in (an_alarm_ends_soon_after_the_attack, a_long_gap_forgets_and_a_short_one_does_not):
        check(support)


class Forgets(Mean):
    name: ClassVar[str] = "forgets"

    def update(self, state, seen, threshold, answers, column, threads=None):
        super().update(state, seen, threshold, answers, column, threads)
        answers.alarm[seen.rows, column] &= seen.valid


class Crowd(Mean):
    name: ClassVar[str] = "crowd"

    def score(self, windows, profile):
        return super().score(windows, profile) / max(len(windows), 1)


class Hoards(Mean):
    name: ClassVar[str] = "hoards"

    def __init__(self) -> None:
        self.seen = 0

    def score(self, windows, profile):
        self.seen += len(windows)
        return super().score(windows, profile) + self.seen * 1e-9


class Elsewhere(Mean):
    name: ClassVar[str] = "elsewhere"

    def update(self, state, seen, threshold, answers, column, threads=None):
        super().update(state, seen, threshold, answers, column, threads)
        answers.scored[:, 0] = True


class NotANumber(Mean):
    name: ClassVar[str] = "not_a_number"

    def score(self, windows, profile):
        return super().score(windows, profile) / np.where(np.abs(windows[:, -1]) > 1e5, 0.0, 1.0)


@pytest.mark.parametrize(
    ("kind", "rule"),
    [
        (Forgets, "an alarm is held in a gap"),
        (Crowd, "in whatever company"),
        (Hoards, "all state is in its arrays|the same bytes|in whatever company"),
        (Elsewhere, "answers stand at the observed rows"),
        (NotANumber, "a statistic is finite"),
        (partial(Mean), "threshold"),
    ],
)
def test_a_detector_that_breaks_a_rule_is_told_which(kind, rule):
    with pytest.raises(BrokenContractError, match="alarm" if rule == "threshold" else rule), np.errstate(all="ignore"):
        check_detector(lambda profiles: kind(), threshold=1e9 if rule == "threshold" else 4.0)


def test_a_score_of_another_shape_is_a_mistake_that_is_named():
    class Wrong(Mean):
        def score(self, windows, profile):
            return np.zeros((len(windows), 1))

    with pytest.raises(TypeError, match=r"detector 'mean': score must be \(0,\) of float64, found \(0, 1\)"):
        check_detector(lambda profiles: Wrong(), threshold=4.0)
