from typing import NamedTuple

import numpy as np

from gpsec.detection.base import Verdict


class Answer(NamedTuple):
    """(m,) statistic, scored and alarm, in the order of the rows that were asked for."""

    statistic: np.ndarray
    scored: np.ndarray
    alarm: np.ndarray


def ask(detector, state, seen, threshold, threads=None) -> Answer:
    """Let a detector take a step; it answers in the second of three columns, at the observed rows, and nowhere else."""
    shape = (state.capacity, 3)
    verdict = Verdict(np.full(shape, -7.0), np.ones(shape, np.bool_), np.ones(shape, np.bool_), 1)
    detector.update(state, seen, threshold, verdict, threads)
    elsewhere = np.ones(shape, np.bool_)
    elsewhere[seen.rows, 1] = False
    assert (verdict.statistic[elsewhere] == -7.0).all()
    assert verdict.scored[elsewhere].all()
    assert verdict.alarm[elsewhere].all()
    return Answer(*verdict.at(seen.rows))
