"""What the loops over rows ask of a detector, and when."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import allocating_kernel, always_inline
from gpsec.core.tables import Table, blank
from gpsec.detection.families import NOT_YET, KernelDetector, each_block, each_residual
from gpsec.testing.detector_bench import Bench

from .test_chi_square import observe


class Diary(NamedTuple):
    """What a row was asked: how often to forget, what it was told of alarms, and the last threshold."""

    forgot: Ints = blank(0)
    alarm_at_forgetting: Flags = blank(False)
    alarm_before: Flags = blank(False)
    alarm_after: Flags = blank(False)
    threshold: Floats = blank(0.0)


@always_inline
def _forget(state, row, alarm):
    state.forgot[row] += 1
    state.alarm_at_forgetting[row] = alarm


@always_inline
def _score(state, seen, i, settings, alarm):
    state.alarm_before[seen.rows[i]] = alarm
    return abs(seen.residual_m[i]) if seen.residual_m[i] < 100.0 else NOT_YET


@always_inline
def _remember(state, seen, i, settings, threshold, alarm):
    state.alarm_after[seen.rows[i]] = alarm
    state.threshold[seen.rows[i]] = threshold


@allocating_kernel
def _workspace():
    return np.empty(4)


@always_inline
def _evaluate(chosen, count, state, seen, settings, profile, work):
    for n in range(count):
        work[n] = seen.residual_m[chosen[n]]


@always_inline
def _score_block(state, seen, i, settings, alarm, work, n):
    state.alarm_before[seen.rows[i]] = alarm
    return abs(work[n]) if work[n] < 100.0 else NOT_YET


@always_inline
def _remember_block(state, seen, i, settings, threshold, alarm, work, n):
    state.alarm_after[seen.rows[i]] = alarm
    state.threshold[seen.rows[i]] = threshold


@dataclass(frozen=True)
class One(KernelDetector):
    name: ClassVar[str] = "one"
    kernel = each_residual(_forget, _score, _remember)

    def new_state(self, capacity):
        return Table(Diary, capacity)


@dataclass(frozen=True)
class Block(One):
    kernel = each_block(4, _workspace, _evaluate, _forget, _score_block, _remember_block)


@pytest.fixture(params=[One, Block])
def bench(request):
    return Bench(request.param(), 1)


def ask(bench, residual_m, *, valid=True, elapsed_steps=1):
    answer = bench.ask(observe(residual_m, valid, elapsed_steps), np.asarray([5.0]))
    return float(answer.statistic[0]), bool(answer.scored[0]), bool(answer.alarm[0])


def test_the_alarm_before_and_after_the_decision_and_the_threshold_are_told(bench):
    diary = bench.state.now
    assert ask(bench, 6.0) == (6.0, True, True)
    assert (diary.alarm_before[0], diary.alarm_after[0], diary.threshold[0]) == (False, True, 5.0)
    assert ask(bench, 4.0) == (4.0, True, False)
    assert (diary.alarm_before[0], diary.alarm_after[0]) == (True, False)


def test_what_is_not_yet_scored_holds_the_alarm_and_is_remembered(bench):
    ask(bench, 6.0)
    bench.state.now.threshold[0] = 0.0
    assert ask(bench, 200.0) == (0.0, False, True)
    assert bench.state.now.alarm_after[0]
    assert bench.state.now.threshold[0] == 5.0


def test_nothing_is_asked_without_a_residual(bench):
    ask(bench, 6.0)
    before = [array.copy() for array in bench.state.now]
    assert ask(bench, 0.0, valid=False, elapsed_steps=30) == (0.0, False, True)
    assert [array.tolist() for array in bench.state.now] == [array.tolist() for array in before]


@pytest.mark.parametrize(("elapsed_steps", "forgot"), [(10, 0), (11, 1)])
def test_more_than_a_second_without_a_residual_is_forgotten(bench, elapsed_steps, forgot):
    """At steps of 0.1 s; the alarm that is held is told."""
    ask(bench, 6.0)
    ask(bench, 1.0, elapsed_steps=elapsed_steps)
    assert bench.state.now.forgot[0] == forgot
    assert bench.state.now.alarm_at_forgetting[0] == bool(forgot)
    assert bench.state.now.alarm_before[0]


def test_an_alarm_is_held_for_five_seconds_without_a_score(bench):
    ask(bench, 6.0)
    assert [ask(bench, 0.0, valid=False)[2] for _ in range(52)] == [True] * 50 + [False] * 2
