"""What the pipeline holds: it observes every step, closes tracks that are over, and writes the tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.geo import Projector
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.hdmap.arrays import Roads
from gpsec.outcomes.accumulate import add_step
from gpsec.outcomes.bands import add_bands, empty_bands, stride
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.closed_store import ClosedStore
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.histograms import BINS, count
from gpsec.outcomes.kept_traces import KeptTraces
from gpsec.outcomes.lanes import Judge, judge_lanes, no_counts
from gpsec.outcomes.samples import SampleTable
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.steps import StepLog
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.streets import Exposure, count_streets
from gpsec.outcomes.study import Study
from gpsec.outcomes.tables import Findings, write_tables
from gpsec.outcomes.view import StepView
from gpsec.types.points import HOLD_S
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity


class Outcomes:
    """Accumulates what each attack achieved against each defence.

    Attributes:
        study: names of plans, detectors, defences, profiles.
        table: running sums of the tracks on the road.
        histogram: (P, profiles, K, 2, BINS) counts of statistics, of samples not attacked and attacked.
        rises: (profiles, K, BINS) from which the alarms of benign vehicles at any threshold follow.
        bands: (P, profiles, D, 2, …) counts of errors by the second of the attack, see `outcomes.bands`.
        lanes: (P, profiles, 3, …) counts of steps on the right lane and not, see `outcomes.lanes`.
        streets: names of the lanes; exposure: what was driven on them.
        traces: what is kept for the traces of the report, None where nothing is.

    """

    def __init__(self, study: Study, roads: Roads, lane_ids: Sequence[str], traces: KeptTraces | None = None) -> None:
        plans, profiles, detectors = len(study.plans), len(study.profiles), len(study.detectors)
        self.study = study
        self.table = Table(OutcomeState, detectors=detectors, defences=len(study.defences))
        self.histogram = np.zeros((plans, profiles, detectors, 2, BINS), np.int64)
        self.bands = empty_bands(plans, profiles, len(study.defences))
        self.rises = np.zeros((profiles, detectors, BINS), np.int64)
        self._stride = stride(study.step_s)
        self._hold_steps = int(HOLD_S / study.step_s + 1e-9)
        self.lanes = no_counts(plans, profiles)
        self._judge = Judge.on(roads, study.step_s)
        self.streets = Streets.on(lane_ids, roads.sides)
        self.exposure = Exposure.none(study, len(self.streets.edge_id))
        self.traces = traces
        self._origin_s = 0.0
        self._closed = ClosedStore(detectors, len(study.defences))

    @property
    def state(self) -> OutcomeState:
        """The running sums."""
        return self.table.now

    def tables(self) -> list[Table[Any] | SampleTable]:
        """Return the tables whose rows are to be grown, copied and reset with those of the tracks."""
        return [self.table] if self.traces is None else [self.table, self.traces.table]

    def observe(self, view: StepView, threads: Threads) -> None:
        """Add one step of the tracks `view.rows`.

        Those on a lane that leads the other way are left out: they have no lane of their own to be displaced in.
        """
        rows, tracks, vehicles, sums = view.rows, view.tracks, view.vehicles, self.state
        benign = rows[tracks.plan[rows] == 0]
        of_vehicle = np.full(len(vehicles.lane), -1, np.int32)
        of_vehicle[tracks.vehicle[benign]] = benign
        sums.twin[rows] = of_vehicle[tracks.vehicle[rows]]
        self._origin_s = round(view.time_s - view.step * view.step_s, 6)
        sides, detector = self._judge.roads.sides, self.study.detector_of
        threads.run(add_step, rows, view.step, tracks, vehicles, view.answers, sums, sides, detector)
        unscored = view.answers.unscored_steps
        count(rows, tracks, vehicles, sums, unscored, self._hold_steps, self.histogram, self.rises)
        count_streets(rows, self.streets.edge, tracks, vehicles, view.answers, sums, self.exposure)
        judge_lanes(rows, self._judge, tracks, vehicles, view.seen, sums, self.lanes)
        add_bands(rows, view.step, self._stride, tracks, vehicles, view.answers.estimate_m, self.bands)
        if self.traces is not None:
            self.traces.observe(view, threads)

    def close(self, rows: Ints, tracks: Tracks, people: Sequence[Identity], ended_s: float | None) -> None:
        """Keep the sums of track rows that are over; `people` holds their vehicles, one a row.

        Call it once for every track, before its row is reset or forked onto, also for those that are still on the
        road when the run ends; `ended_s` is the simulated time at which they left, None for these.
        """
        if len(rows) > 0:
            closed = ClosedTracks.at(rows, tracks, self.state, people, ended_s)
            self._closed.add(closed)
            if self.traces is not None:
                self.traces.close(rows, closed)

    def tracks(self) -> ClosedTracks:
        """Return all closed tracks, ordered by vehicle and plan."""
        return self._closed.all()

    def write_traces(self, log: StepLog) -> None:
        """Write the traces that are kept into a log of steps."""
        if self.traces is not None:
            self.traces.write(log, self.study, self._origin_s)

    def write(
        self,
        folder: Path,
        scenario: str,
        seed: int,
        *,
        replicates: int = 1000,
        confidence: float = 0.95,
        projector: Projector | None = None,
    ) -> None:
        """Write the tables of the closed tracks into `folder`; intervals by bootstrap over vehicles.

        `projector` is that of the net; without one, the net counts as one without a projection.
        """
        found = self.histogram, self.rises, self.bands, self.lanes, self.streets, self.exposure
        findings = Findings(self.study, self.tracks(), *found, self._origin_s)
        write_tables(folder, scenario, findings, Bootstrap(seed, replicates, confidence), projector or Projector("!"))
