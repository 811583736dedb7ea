"""The last minute of every track, in single precision: what the traces of a run are cut from."""

from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import Table, blank
from gpsec.outcomes.study import Study
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# What is kept of a journey before and after an attack, and how often.
BEFORE_S, AFTER_S, EVERY_S = 10.0, 20.0, 0.2
# TrackSamples of a track; where an attack lasts longer, every other one of them goes.
SAMPLES_OF_TRACK = 200
# Memory for all of them. Tracks that would need more have none.
SAMPLE_BYTES = 64_000_000

_SINGLE = np.float32(0.0)


class TrackSamples(NamedTuple):
    """T samples of each of M track rows, with K detectors and D defences.

    The sample behind the last one is being made: fixes, camera, residuals and statistics that came since the last one
    are in it already.

    Attributes:
        complete: (M,) number of samples.
        stride: (M,) they are that many times `EVERY_S` apart.
        step: (M, T) of the sample.
        lane, rear_m, yaw_rad, speed_mps, lane_offset_m: (M, T, …) truth, as in `Vehicles`.
        settled, attacked: (M, T) as in `Tracks`.
        fix_m, fix_valid: (M, T, …) the last fix since the sample before, after the attack.
        camera_offset_m, camera_valid, residual_m, residual_valid: (M, T) likewise.
        statistic, scored: (M, T, K) likewise; alarm: (M, T, K) in the step.
        off_m: (M, T, D, 2) estimate less truth; isolated: (M, T, D).
    """

    complete: Ints = blank(0)
    stride: Ints = blank(1)
    step: Ints = blank(0, "samples")
    lane: Ints = blank(0, "samples")
    rear_m: Floats = blank(0.0, "samples", 2)
    yaw_rad: Floats = blank(_SINGLE, "samples")
    speed_mps: Floats = blank(_SINGLE, "samples")
    lane_offset_m: Floats = blank(_SINGLE, "samples")
    settled: Flags = blank(False, "samples")
    attacked: Flags = blank(False, "samples")
    fix_m: Floats = blank(0.0, "samples", 2)
    fix_valid: Flags = blank(False, "samples")
    camera_offset_m: Floats = blank(_SINGLE, "samples")
    camera_valid: Flags = blank(False, "samples")
    residual_m: Floats = blank(_SINGLE, "samples")
    residual_valid: Flags = blank(False, "samples")
    statistic: Floats = blank(_SINGLE, "samples", "detectors")
    scored: Flags = blank(False, "samples", "detectors")
    alarm: Flags = blank(False, "samples", "detectors")
    off_m: Floats = blank(_SINGLE, "samples", "defences", 2)
    isolated: Flags = blank(False, "samples", "defences")


class SamplePace(NamedTuple):
    """How often is sampled, and how many samples are kept before an attack; how many steps after it are looked at."""

    every: int
    before: int
    after: int

    @classmethod
    def at(cls, step_s: float) -> "SamplePace":
        """Return that of a step length."""
        every = max(1, round(EVERY_S / step_s))
        return cls(every, min(round(BEFORE_S / (every * step_s)), SAMPLES_OF_TRACK // 2), round(AFTER_S / step_s))


class SampleTable:
    """The samples of the first track rows: of as many as there is memory for, which is taken when they are used."""

    def __init__(self, study: Study) -> None:
        lengths = {"samples": SAMPLES_OF_TRACK, "detectors": len(study.detectors), "defences": len(study.defences)}
        of_a_row = sum(array.nbytes for array in Table(TrackSamples, 1, **lengths).arrays())
        self._table = Table(TrackSamples, max(1, SAMPLE_BYTES // of_a_row), **lengths)

    @property
    def now(self) -> TrackSamples:
        """The samples."""
        return self._table.now

    def grow(self, capacity: int) -> None:
        """Do nothing: there is room for all rows that are kept."""

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`; what counts and flags say is not there need not be wiped out."""
        mine, now = rows[rows < self._table.capacity], self.now
        now.complete[mine], now.stride[mine] = 0, 1
        for flags in (now.fix_valid, now.camera_valid, now.residual_valid, now.scored):
            flags[mine, 0] = False

    def copy(self, source: Ints, target: Ints) -> None:
        """Copy the rows `source` onto the rows `target`; of what is not kept, there is nothing to copy."""
        both = (source < self._table.capacity) & (target < self._table.capacity)
        most = int(self.now.complete[source[both]].max(initial=-1)) + 1
        for array in self._table.arrays():
            if array.ndim == 1:
                array[target[both]] = array[source[both]]
            else:
                array[target[both], :most] = array[source[both], :most]
        self.reset(target[~both])


@kernel
def take_samples(
    rows: Ints,
    step: int,
    pace: SamplePace,
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
    answers: Answers,
    samples: TrackSamples,
) -> None:
    """Take in a step of the track rows `rows`, ascending, and complete the samples that are due in it."""
    for row in rows:
        if row >= len(samples.complete):
            break
        end_step = tracks.end_step[row]
        if end_step >= 0 and step > end_step + pace.after:
            continue
        if step == tracks.start_step[row]:
            _keep_last(row, pace.before, samples)
        place, v = samples.complete[row], tracks.vehicle[row]
        _hold(row, place, v, tracks, seen, answers, samples)
        if step % (pace.every * samples.stride[row]) == 0:
            _complete(row, place, v, step, tracks, vehicles, answers, samples)
            if samples.complete[row] == samples.step.shape[1] - 1:
                if tracks.start_step[row] < 0:
                    _keep_last(row, pace.before, samples)
                else:
                    _thin(row, pace.every, samples)
            _begin(row, samples.complete[row], samples)


@inline
def _hold(
    row: int, place: int, v: int, tracks: Tracks, seen: Measurements, answers: Answers, samples: TrackSamples
) -> None:
    if tracks.fix_valid[row]:
        samples.fix_valid[row, place] = True
        samples.fix_m[row, place, 0], samples.fix_m[row, place, 1] = tracks.fix_m[row, 0], tracks.fix_m[row, 1]
    if seen.camera_valid[v]:
        samples.camera_valid[row, place] = True
        samples.camera_offset_m[row, place] = -seen.lane_poly[v, 0]
    if tracks.residual_valid[row]:
        samples.residual_valid[row, place] = True
        samples.residual_m[row, place] = tracks.residual_m[row]
    for k in range(answers.scored.shape[1]):
        if answers.scored[row, k]:
            samples.scored[row, place, k] = True
            samples.statistic[row, place, k] = answers.statistic[row, k]


@inline
def _complete(
    row: int,
    place: int,
    v: int,
    step: int,
    tracks: Tracks,
    vehicles: Vehicles,
    answers: Answers,
    samples: TrackSamples,
) -> None:
    samples.step[row, place] = step
    samples.lane[row, place] = vehicles.lane[v]
    samples.rear_m[row, place, 0], samples.rear_m[row, place, 1] = vehicles.rear_m[v, 0], vehicles.rear_m[v, 1]
    samples.yaw_rad[row, place], samples.speed_mps[row, place] = vehicles.yaw_rad[v], vehicles.speed_mps[v]
    samples.lane_offset_m[row, place] = vehicles.lane_offset_m[v]
    samples.settled[row, place], samples.attacked[row, place] = tracks.settled[row], tracks.attacked[row]
    for k in range(answers.alarm.shape[1]):
        samples.alarm[row, place, k] = answers.alarm[row, k]
    for d in range(answers.isolated.shape[1]):
        samples.isolated[row, place, d] = answers.isolated[row, d]
        for axis in range(2):
            samples.off_m[row, place, d, axis] = answers.estimate_m[row, d, axis] - vehicles.rear_m[v, axis]
    samples.complete[row] = place + 1


@inline
def _begin(row: int, place: int, samples: TrackSamples) -> None:
    samples.fix_valid[row, place] = samples.camera_valid[row, place] = samples.residual_valid[row, place] = False
    for k in range(samples.scored.shape[2]):
        samples.scored[row, place, k] = False


@inline
def _keep_last(row: int, most: int, samples: TrackSamples) -> None:
    """Leave the last `most` samples, and the one that is being made."""
    away = samples.complete[row] - most
    if away > 0:
        for place in range(most + 1):
            _move(row, place + away, place, samples)
        samples.complete[row] = most


@inline
def _thin(row: int, every: int, samples: TrackSamples) -> None:
    """Leave every other sample: those in whose steps one is due at twice the stride."""
    samples.stride[row] *= 2
    kept = 0
    for place in range(samples.complete[row]):
        if samples.step[row, place] % (every * samples.stride[row]) == 0:
            _move(row, place, kept, samples)
            kept += 1
    samples.complete[row] = kept


@inline
def _move(row: int, source: int, target: int, samples: TrackSamples) -> None:
    samples.step[row, target] = samples.step[row, source]
    samples.lane[row, target] = samples.lane[row, source]
    samples.yaw_rad[row, target] = samples.yaw_rad[row, source]
    samples.speed_mps[row, target] = samples.speed_mps[row, source]
    samples.lane_offset_m[row, target] = samples.lane_offset_m[row, source]
    samples.settled[row, target] = samples.settled[row, source]
    samples.attacked[row, target] = samples.attacked[row, source]
    samples.fix_valid[row, target] = samples.fix_valid[row, source]
    samples.camera_offset_m[row, target] = samples.camera_offset_m[row, source]
    samples.camera_valid[row, target] = samples.camera_valid[row, source]
    samples.residual_m[row, target] = samples.residual_m[row, source]
    samples.residual_valid[row, target] = samples.residual_valid[row, source]
    for axis in range(2):
        samples.rear_m[row, target, axis] = samples.rear_m[row, source, axis]
        samples.fix_m[row, target, axis] = samples.fix_m[row, source, axis]
    for k in range(samples.scored.shape[2]):
        samples.statistic[row, target, k] = samples.statistic[row, source, k]
        samples.scored[row, target, k] = samples.scored[row, source, k]
        samples.alarm[row, target, k] = samples.alarm[row, source, k]
    for d in range(samples.isolated.shape[2]):
        samples.isolated[row, target, d] = samples.isolated[row, source, d]
        for axis in range(2):
            samples.off_m[row, target, d, axis] = samples.off_m[row, source, d, axis]


def samples_of(row: int, samples: TrackSamples) -> dict[str, Any]:
    """Return copies of the complete samples of a track row, by field."""
    number = int(samples.complete[row])
    fields = [name for name in TrackSamples._fields if name not in ("complete", "stride")]
    return {name: getattr(samples, name)[row, :number].copy() for name in fields}
