"""What the pipeline holds: it observes every step, closes tracks that are over, and writes the tables."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import Projector
from gpsec.core.threads import Threads
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.accumulate import add_alarms, add_errors
from gpsec.outcomes.bands import add_bands, empty_bands, stride
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.events import ClosedTracks, Journey
from gpsec.outcomes.histograms import BINS, count
from gpsec.outcomes.places import note_places
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.outcomes.tables import write_tables
from gpsec.outcomes.view import StepView
from gpsec.types.tracks import Tracks

# Times that tracks are closed until what was kept of them is joined.
_JOINED_AT_ONCE = 256


class Outcomes:
    """Accumulates what each attack achieved against each defence.

    Attributes:
        study: names of plans, detectors, defences, profiles.
        state: running sums of the tracks on the road; the pipeline grows, copies and resets its rows with theirs.
        histogram: (P, profiles, K, 2, BINS) counts of statistics, of samples not attacked and attacked.
        bands: (P, profiles, D, 2, …) counts of errors by the second of the attack, see `outcomes.bands`.

    """

    def __init__(
        self,
        plan_names: Sequence[str],
        detector_names: Sequence[str],
        defences: Sequence[tuple[str, str]],
        profile_names: Sequence[str],
        thresholds: Floats,
        lane_sides: LaneSides,
        step_s: float,
        capacity: int,
    ) -> None:
        self.study = Study(
            tuple(plan_names),
            tuple(detector_names),
            tuple(defences),
            tuple(profile_names),
            np.asarray(thresholds, np.float64).reshape(len(profile_names), len(detector_names)),
            step_s,
        )
        self.state = OutcomeState.empty(capacity, len(detector_names), len(defences))
        self.histogram = np.zeros((len(plan_names), len(profile_names), len(detector_names), 2, BINS), np.int64)
        self.bands = empty_bands(len(plan_names), len(profile_names), len(defences))
        self._stride = stride(step_s)
        self._sides = lane_sides
        self._origin_s = 0.0
        self._closed: list[ClosedTracks] = []
        self._just_closed: list[ClosedTracks] = []

    def observe(self, view: StepView, threads: Threads) -> None:
        """Add one step of the tracks `view.rows`.

        Those on a lane that leads the other way are left out: they have no lane of their own to be displaced in.
        """
        state, tracks, vehicles = self.state, view.tracks, view.vehicles
        against = vehicles.against[tracks.vehicle[view.rows]]
        rows, out = view.rows[~against], view.rows[against]
        state.left_out[out] += tracks.attacked[out]
        self._origin_s = round(view.time_s - view.step * view.step_s, 6)
        threads.run(
            add_alarms,
            rows,
            view.step,
            tracks.plan,
            tracks.settled,
            tracks.attacked,
            view.statistic,
            view.scored,
            view.alarm,
            state.in_event,
            state.counts,
            state.onsets,
            state.in_alarm,
            state.in_alarm_at_start,
            state.detection_step,
            state.bin,
        )
        threads.run(
            add_errors,
            rows,
            view.step,
            tracks.vehicle,
            tracks.plan,
            tracks.settled,
            tracks.attacked,
            tracks.end_step,
            vehicles.rear_m,
            vehicles.lane_yaw_rad,
            vehicles.lane,
            vehicles.width_m,
            self._sides,
            view.estimate_m,
            view.isolated,
            self.study.detector_of,
            state.detection_step,
            state.in_event,
            state.steps,
            state.squared_m2,
            state.max_cross_m,
            state.first_step,
            state.deviation_m,
            state.isolated_steps,
            state.retrust_step,
        )
        threads.run(
            note_places,
            view.rows,
            view.step,
            tracks.vehicle,
            tracks.plan,
            tracks.start_step,
            state.detection_step,
            state.first_step,
            vehicles.rear_m,
            state.start_m,
            state.detected_m,
            state.left_lane_m,
        )
        count(rows, tracks.vehicle, tracks.plan, tracks.attacked, vehicles.profile, state.bin, self.histogram)
        add_bands(
            rows,
            view.step,
            self._stride,
            tracks.vehicle,
            tracks.plan,
            tracks.attacked,
            tracks.start_step,
            vehicles.profile,
            vehicles.rear_m,
            vehicles.lane_yaw_rad,
            view.estimate_m,
            self.bands,
        )

    def close(self, rows: Ints, tracks: Tracks, journeys: Sequence[Journey]) -> None:
        """Keep the sums of track rows that are over; `journeys` holds their vehicles, one a row.

        Call it once for every track, before its row is reset or forked onto, also for those that are still on the
        road when the run ends.
        """
        if len(rows) > 0:
            self._just_closed.append(ClosedTracks.at(rows, tracks, self.state, journeys))
        # Many small arrays take several times the memory of few large ones.
        if len(self._just_closed) == _JOINED_AT_ONCE:
            self._closed.append(ClosedTracks.concatenate(self._just_closed))
            self._just_closed = []

    def tracks(self) -> ClosedTracks:
        """Return all closed tracks, ordered by vehicle and plan."""
        none = ClosedTracks.none(len(self.study.detectors), len(self.study.defences))
        return ClosedTracks.concatenate([none, *self._closed, *self._just_closed])

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
        write_tables(
            folder,
            scenario,
            self.study,
            self.tracks(),
            self.histogram,
            self.bands,
            self._origin_s,
            Bootstrap(seed, replicates, confidence),
            projector or Projector("!"),
        )
