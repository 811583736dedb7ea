"""A first try of somebody's detector: whether it answers as it has to, and what it costs, before hours go into it."""

import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any, TypeVar

import numpy as np

from gpsec.core.errors import GpsecError, shown
from gpsec.core.tables import Table
from gpsec.detection.base import Detector
from gpsec.detection.logs import Grid
from gpsec.detection.models import build_detectors, gates_for
from gpsec.detection.monitored import monitored
from gpsec.detection.registry import DETECTORS, Entry
from gpsec.scenario.parts import use
from gpsec.sensors.registry import PROFILES
from gpsec.training.collect import residual_log
from gpsec.training.pool import tell_progress
from gpsec.training.recordings import Recordings
from gpsec.types.answers import Answers
from gpsec.types.constants import MODELLED

MOST_US = 200.0
"""What a detector may cost, in microseconds a track-step."""
_VEHICLES, _STEPS = 100, 900
# Steps that may compile, and so many after them that a detector cannot have been slow by chance.
_WARM, _ENOUGH = 50, 100
_BEGINS = 200
_BIAS_SCALES, _ABSURD = 5.0, 1e6
_T = TypeVar("_T")


@dataclass(frozen=True)
class TryOut:
    """What is tried.

    Attributes:
        detector: its name.
        parts: its reference, where it is no part of gpsec.
        profile: sensors of the vehicles.
        traffic: recordings.
        network, seed: of the recording that it is tried on.
    """

    detector: str
    parts: tuple[str, ...]
    profile: str
    traffic: Recordings
    network: str
    seed: int


def try_out(wanted: TryOut) -> float:
    """Let a detector learn a little, and look at honest, spoofed and absurd residuals; return µs a track-step.

    Raises:
        GpsecError: it fails, answers what is no statistic, or takes longer than `MOST_US`.
    """
    use(wanted.parts)
    name, entry, profile = wanted.detector, DETECTORS[wanted.detector], PROFILES[wanted.profile]
    tell_progress(name, "sensing", 0, 1)
    recording, net = wanted.traffic.read(wanted.network, wanted.seed), wanted.traffic.nets[wanted.network]
    watched = entry.reads_monitor
    log = residual_log(recording, net, wanted.network, profile, MODELLED[0], wanted.seed, watched)
    if not wanted.parts:
        (detector,) = build_detectors([name], [wanted.profile], MODELLED[0])
    else:
        detector = _learned(entry, name, log)
    if not isinstance(detector, Detector):
        raise GpsecError(f"detector '{name}': expected one that scores residuals, found one that is told the truth")
    grid = Grid.of([log])
    grid = grid.select(np.arange(len(grid.length)) < _VEHICLES)
    if watched:
        grid = monitored(grid, float(gates_for([wanted.profile], MODELLED[0])[0]))
    tell_progress(name, "trying it", 0, 1)
    spoofed = grid.residual_m.copy()
    spoofed[_BEGINS:] += _BIAS_SCALES * grid.scale_m
    look(detector, grid)  # the first look compiles
    look(detector, replace(grid, residual_m=_ABSURD * grid.residual_m))
    cost_us = look(detector, replace(grid, residual_m=spoofed))
    check_cost(name, cost_us)
    return cost_us


def check_cost(name: str, cost_us: float) -> None:
    """Refuse a detector that takes too long.

    Raises:
        GpsecError: it takes longer than `MOST_US`.
    """
    if cost_us > MOST_US:
        raise GpsecError(
            f"detector '{name}': expected at most {MOST_US:g} µs of processor time a track-step, found {cost_us:.0f}"
        )


def look(detector: Detector, grid: Grid) -> float:
    """Let a detector look at a grid, and check every answer; return the µs of processor time a track-step.

    Raises:
        GpsecError: it fails, scores nothing, answers what is no statistic, or takes longer than `MOST_US`.
    """
    vehicles, steps = len(grid.length), min(len(grid.valid), _STEPS)
    state = guarded(lambda: detector.new_state(vehicles).now, detector.name, "new_state")
    answers = Table(Answers, vehicles, detectors=1, defences=0).now
    spent_s, timed, looked, scored = 0.0, 0, 0, 0
    for step in range(steps):
        seen = grid.observe(step)
        rows, threshold = seen.rows, np.full(len(seen.rows), np.inf)
        began = process_time()
        guarded(lambda: detector.update(state, seen, threshold, answers, 0), detector.name, "update")  # noqa: B023
        if step >= _WARM:
            spent_s += process_time() - began
            timed += len(rows)
        if step == _WARM + _ENOUGH:
            check_cost(detector.name, spent_s / max(timed, 1) * 1e6)
        looked += len(rows)
        scored += int(answers.scored[rows, 0].sum())
        check_statistics(detector.name, answers.statistic[rows, 0], step * grid.step_s)
    if not scored:
        raise GpsecError(f"detector '{detector.name}': expected scores of {looked} residuals, found none")
    return spent_s / max(timed, 1) * 1e6


def check_statistics(name: str, statistic: Any, time_s: float) -> None:
    """Refuse statistics of a detector that are none, found at some time.

    Raises:
        GpsecError: one is NaN, infinite or below 0.
    """
    wrong = ~(np.isfinite(statistic) & (statistic >= 0.0))
    if wrong.any():
        found = float(statistic[wrong][0])
        raise GpsecError(f"detector '{name}': expected finite statistics of at least 0, found {found} at {time_s:g} s")


def guarded(call: Callable[[], _T], name: str, what: str) -> _T:
    """Return what a call of somebody's code returns.

    Raises:
        GpsecError: it failed; the sentence says where.
    """
    try:
        return call()
    except GpsecError:
        raise
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        said = str(error).removeprefix(f"detector '{name}': ") or type(error).__name__
        raise GpsecError(
            f"detector '{name}': {what}: {shown(said)} ({Path(last.filename).name}:{last.lineno})"
        ) from error


def _learned(entry: Entry, name: str, log: Any) -> Any:
    """Return a detector of somebody's, with what it learns from one log."""
    learned = []
    if entry.learn is not None:
        learn = entry.learn
        learned = [guarded(lambda: learn([log], 1, lambda *told: tell_progress(name, *told)), name, "learn")]
    return guarded(lambda: entry.build(learned), name, "from_learned" if learned else "making it")
