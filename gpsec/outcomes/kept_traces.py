"""Which traces a run keeps: of each defence those of the largest error, of the median one, and the first attack missed.

Nobody knows before the end which defence is the best, what its largest error is, or where the median lies. So samples
are taken of all tracks on the road (`outcomes.samples`), and of those that are over the traces are kept that may still
be asked for: under each defence the worst so far, the first missed so far, and a window about the median so far. Of n
attacks that come in any order the median moves by some √n places, so that a window seldom loses it; where it does, the
nearest trace is kept, and its rank says so. The window is that of Munro and Paterson, Selection and sorting with
limited storage, Theoretical Computer Science 12 (1980).
"""

from bisect import insort
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.threads import Threads
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.samples import SamplePace, SampleTable, samples_of, take_samples
from gpsec.outcomes.state import ATTACK
from gpsec.outcomes.steps import StepLog
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView

# Traces about the median so far, under each defence.
MEDIAN_WINDOW = 16


@dataclass(frozen=True, order=True)
class Trace:
    """What is kept of one attack on one vehicle.

    Attributes:
        vehicle_id: of the vehicle; plan: index of the plan.
        start_step: of the attack.
        samples: fields of `TrackSamples` without its row, from before the attack on.
    """

    vehicle_id: str
    plan: int
    start_step: int = field(compare=False)
    samples: dict[str, Any] = field(compare=False)


@dataclass
class Candidates:
    """The traces that may still be asked for under one defence.

    Attributes:
        worst: of the largest error, with it.
        missed: of the first attack that was not seen, with its step.
        middle: about the median error, with theirs, ascending; next to each other among all that came.
        below, above: how many came that lie on either side of these.
    """

    worst: tuple[float, Trace] | None = None
    missed: tuple[int, Trace] | None = None
    middle: list[tuple[float, Trace]] = field(default_factory=list)
    below: int = 0
    above: int = 0

    def add(self, error_m: float, *, seen: bool, trace: Trace) -> None:
        """Take in an attack that is over: the largest error across the lane, and whether it was seen."""
        if self.worst is None or (error_m, trace) > self.worst:
            self.worst = error_m, trace
        if not seen and (self.missed is None or (trace.start_step, trace) < self.missed):
            self.missed = trace.start_step, trace
        one = error_m, trace
        if self.below and one < self.middle[0]:
            self.below += 1
        elif self.above and one > self.middle[-1]:
            self.above += 1
        else:
            insort(self.middle, one)
        if len(self.middle) > MEDIAN_WINDOW:
            self._shorten()

    def _shorten(self) -> None:
        if self.below < self.above or (self.below == self.above and self.below % 2 == 0):
            del self.middle[0]
            self.below += 1
        else:
            del self.middle[-1]
            self.above += 1

    def chosen(self) -> Iterator[Trace]:
        """Yield the traces of the largest and of the median error, and of the first attack missed."""
        if self.worst is not None:
            middle = (self.below + len(self.middle) + self.above - 1) // 2 - self.below
            yield self.worst[1]
            yield self.middle[min(max(middle, 0), len(self.middle) - 1)][1]
        if self.missed is not None:
            yield self.missed[1]


class KeptTraces:
    """Samples of the tracks on the road, and the traces that are kept of those that are over.

    Attributes:
        table: of the samples; the pipeline grows, copies and resets its rows with those of the tracks.
    """

    def __init__(self, study: Study) -> None:
        self.table = SampleTable(study)
        self._pace = SamplePace.at(study.step_s)
        self._detector_of = study.detector_of
        self._candidates = [[Candidates() for _ in study.defences] for _ in study.profiles]

    def observe(self, view: StepView, threads: Threads) -> None:
        """Take in one step of the tracks `view.rows`."""
        now = self.table.now
        told = view.tracks, view.vehicles, view.seen, view.answers
        threads.run(take_samples, view.rows, view.step, self._pace, *told, now)

    def close(self, rows: Ints, closed: ClosedTracks) -> None:
        """Take in tracks that are over, before their rows are used again."""
        state = closed.state
        known = (
            (closed.plan > 0) & state.in_event & (state.steps[:, ATTACK] > 0) & (rows < len(self.table.now.complete))
        )
        for place in np.flatnonzero(known).tolist():
            trace = Trace(
                str(closed.vehicle_id[place]),
                int(closed.plan[place]),
                int(closed.start_step[place]),
                samples_of(int(rows[place]), self.table.now),
            )
            seen = (state.detection_step[place] >= 0)[self._detector_of].tolist()
            errors_m = state.max_cross_m[place, :, ATTACK].tolist()
            candidates = self._candidates[closed.profile[place]]
            for mine, error_m, detected in zip(candidates, errors_m, seen, strict=True):
                mine.add(error_m, seen=detected, trace=trace)

    def chosen(self) -> Sequence[Trace]:
        """Return the traces that are kept, by vehicle and plan."""
        found = {trace for profile in self._candidates for mine in profile for trace in mine.chosen()}
        return sorted(found)

    def write(self, log: StepLog, study: Study, origin_s: float) -> None:
        """Write the traces that are kept into a log of steps; `origin_s` is the simulated time of step 0.

        Before the attack they are those of the vehicle without one, which other traces of the vehicle may have too.
        """
        told: set[tuple[str, int]] = set()
        for trace in self.chosen():
            values = dict(trace.samples)
            steps = values.pop("step")
            before = (steps < trace.start_step).tolist()
            honest = [(trace.vehicle_id, step) for step in steps.tolist()]
            new = np.array([not early or one not in told for early, one in zip(before, honest, strict=True)])
            told.update(one for early, one in zip(before, honest, strict=True) if early)
            values |= {
                "time_s": np.round(origin_s + steps * study.step_s, 6),
                "vehicle_id": np.full(len(steps), trace.vehicle_id, object),
                "plan": np.where(before, study.plans[0], study.plans[trace.plan]).astype(object),
                "estimate_m": values["rear_m"][:, None] + values.pop("off_m"),
            }
            log.add({name: column[new] for name, column in values.items()})
