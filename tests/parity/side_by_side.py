"""A method that runs both engines on the same tracks and compares them after every step."""

from collections import Counter, defaultdict
from dataclasses import dataclass, field

import numpy as np

from gpsec.attacks.probing import Probed, Question
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.threads import Threads
from gpsec.localization.gated import LEARNT_NOISE
from gpsec.pipeline.batched import BatchedMethod
from gpsec.reference.learning import GatedEkf, LaneUkf
from gpsec.reference.method import ReferenceMethod
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

from .drive import Drive, detection_for, localization_for

# Of 45 fixes that are tried, every so many-th is tried in the reference, too.
_EVERY = 9


@dataclass
class Comparison:
    """What was found over all tracks and steps.

    Attributes:
        worst: largest difference of each quantity (nan if a value is not a number).
        disagreements: number of differences in what is true or false.
        seen: how often each situation came about, so that a comparison cannot be empty.
    """

    worst: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    disagreements: Counter[str] = field(default_factory=Counter)
    seen: Counter[str] = field(default_factory=Counter)

    def close(self, quantity: str, one, other) -> None:
        self._note(quantity, np.abs(np.asarray(one) - np.asarray(other)))

    def relative(self, quantity: str, one, other) -> None:
        """For what may be large: a statistic of a residual of many standard deviations."""
        self._note(quantity, np.abs(one - other) / np.maximum(np.abs(other), 1.0))

    def _note(self, quantity: str, difference) -> None:
        self.worst[quantity] = float(np.maximum(self.worst[quantity], np.max(difference, initial=0.0)))

    def same(self, quantity: str, one, other) -> None:
        self.disagreements[quantity] += int(np.sum(np.asarray(one) != np.asarray(other)))


class SideBySide:
    """Implements `gpsec.types.method.Method`; the attacker sees the batched answers."""

    def __init__(self, drive: Drive, copies: bool = False) -> None:
        ground = drive.ground
        self.detection = detection_for(ground.world, ground.choice.profiles)
        localization = localization_for(ground, self.detection)
        parts = ground.world, ground.association, self.detection, localization
        self.batched = BatchedMethod(*parts, copies=copies)
        self.reference = ReferenceMethod(ground.hd_map, *parts, copies=copies)
        self.answers = self.batched.answers
        self.found = Comparison()
        self._responses = [response.name for response in localization.responses]
        self._internal = ground.hd_map.sides.internal
        self._lane_of_segment = ground.hd_map.lanes.lane

    def grow(self, capacity: int) -> None:
        self.batched.grow(capacity)
        self.reference.grow(capacity)

    def reset(self, rows: Ints) -> None:
        self.batched.reset(rows)
        self.reference.reset(rows)

    def copy(self, source: Ints, target: Ints) -> None:
        self.batched.copy(source, target)
        self.reference.copy(source, target)
        self.found.seen["fork"] += len(source)

    def step(
        self,
        number: int,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
        watch: Stopwatch,
    ) -> None:
        isolated_before = self.batched.answers.isolated[rows].copy()
        lane_before = tracks.lane.copy()
        self.reference.step(number, rows, tracks, vehicles, seen, threads, watch)
        residual, valid = tracks.residual_m[rows].copy(), tracks.residual_valid[rows].copy()
        paired = tracks.paired_m[rows][valid]
        lanes = [one[rows].copy() for one in (tracks.lane, tracks.lane_known, tracks.unmatched)]
        tracks.lane[:] = lane_before  # both go on from the lane of the step before
        self.batched.step(number, rows, tracks, vehicles, seen, threads, watch)
        found = self.found
        found.close("residual", residual, tracks.residual_m[rows])
        found.same("residual valid", valid, tracks.residual_valid[rows])
        for name, one in zip(("lane", "lane_known", "unmatched"), lanes, strict=True):
            found.same(name, one, getattr(tracks, name)[rows])
        self._compare_detectors(rows)
        for row in rows.tolist():
            self._compare_monitors(row)
            self._compare_filters(row)
        isolated = self.batched.answers.isolated[rows]
        lane = vehicles.lane[tracks.vehicle[rows]]
        matched = tracks.segment[rows]
        found.seen["track step"] += len(rows)
        found.seen["residual"] += int(valid.sum())
        both = tracks.fix_valid[rows] & seen.camera_valid[tracks.vehicle[rows]]
        found.seen["late residual"] += int((valid & ~both).sum())
        found.close("paired fix", paired, tracks.paired_m[rows][valid])
        found.seen["on another lane"] += int((valid & (self._lane_of_segment[matched] != lane)).sum())
        found.seen["in a junction"] += int(self._internal[lane].sum())
        found.seen["isolated"] += int(isolated.sum())
        found.seen["isolation begins"] += int((isolated & ~isolated_before).sum())
        found.seen["isolation ends"] += int((isolated_before & ~isolated).sum())

    def probe(
        self, number: int, asked: Question, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads
    ) -> Probed:
        """Compare what both say of some of the fixes; the attacker goes by the batched answers."""
        told = self.batched.probe(number, asked, tracks, vehicles, seen, threads)
        some = asked._replace(moved_m=asked.moved_m[:, ::_EVERY])
        other = self.reference.probe(number, some, tracks, vehicles, seen, threads)
        found, whose = self.found, "own copy" if asked.own_copy else "probe"
        found.relative(whose, told.ratio[:, ::_EVERY], other.ratio)
        found.same(f"{whose} scored", told.scored[:, ::_EVERY], other.scored)
        found.seen[f"{whose} passes"] += int((told.scored & (told.ratio <= 1.0)).sum())
        found.seen[f"{whose} alarm"] += int((told.scored & (told.ratio > 1.0)).sum())
        return told

    def _compare_detectors(self, rows: Ints) -> None:
        one, other = self.reference.answers, self.batched.answers
        for k, name in enumerate(self.detection.names):
            self.found.relative(name, one.statistic[rows, k], other.statistic[rows, k])
            self.found.same(f"{name} scored", one.scored[rows, k], other.scored[rows, k])
            self.found.same(f"{name} alarm", one.alarm[rows, k], other.alarm[rows, k])
            self.found.seen[f"{name} alarm"] += int(other.alarm[rows, k].sum())
        self.found.close("estimate", one.estimate_m[rows], other.estimate_m[rows])
        self.found.same("isolated", one.isolated[rows], other.isolated[rows])

    def _compare_monitors(self, row: int) -> None:
        found, one, state = self.found, self.reference.track(row).monitor, self.batched.monitor
        found.same("monitor started", one.ekf is not None, state.started[row])
        if one.ekf is None:
            return
        found.close("monitor state", one.ekf.mean, state.mean[row])
        found.close("monitor covariance", one.ekf.covariance, state.covariance[row])
        found.close("slow part", one.slow.all, [*state.slow[row], *state.slow_covariance[row]])
        found.same("monitor alarm", one.alarm, state.alarm[row])
        found.seen["monitor alarm"] += int(state.alarm[row])
        found.seen["monitor blind"] += 0.35 < state.blind_s[row] < 10.0
        learnt = np.array([state.gnss[row], state.camera[row], state.scale[row]])
        found.close("learnt", one.learnt, learnt)
        found.seen["monitor has learnt"] += bool(np.abs(learnt).max() > 0.05)

    def _compare_filters(self, row: int) -> None:
        found, state = self.found, self.batched.filters
        defences = self.reference.track(row).localization.defences
        found.same("filter started", bool(defences), state.cells.started[row])
        for d, defence in enumerate(defences):
            filters, branch = state.of(d)
            at = branch[row]
            mean, covariance = filters.mean[at], filters.covariance[at]
            found.seen["repair"] += int(filters.repairs[at])
            if defence.ekf is not None:
                size = len(defence.ekf.mean)
                learning = "learning " * (size > 5)
                found.close(f"{learning}EKF state", defence.ekf.mean, mean[:size])
                found.close(f"{learning}EKF covariance", defence.ekf.covariance, covariance[:size, :size])
                found.same("EKF update", defence.ekf.nis is not None, filters.innovation_valid[at])
                if defence.ekf.nis is not None:
                    nis = float((filters.innovation[at] ** 2).sum())
                    found.relative("EKF NIS", defence.ekf.nis, nis)
            if isinstance(defence.ekf, GatedEkf):
                found.close("gate's noise", defence.ekf.learnt, mean[LEARNT_NOISE])
                found.seen["gate has learnt"] += bool(abs(mean[LEARNT_NOISE]) > 0.05)
            if isinstance(defence.ukf, LaneUkf):
                order = [0, 1, 2, 5, 6, 3, 4]
                found.close("lane UKF state", defence.ukf.state, mean[order])
                found.close("lane UKF covariance", defence.ukf.state_covariance, covariance[np.ix_(order, order)])
                found.seen["lane correction"] += defence.corrected
                found.seen["lane rollback"] += defence.went_back
            elif defence.ukf is not None:
                found.seen["rollback"] += defence.went_back
                found.close("UKF state", [*defence.ukf.mean, defence.ukf.yaw_rad], mean[:3])
                found.close("UKF covariance", defence.ukf.covariance, covariance[:2, :2])
                found.close("UKF yaw variance", defence.ukf.yaw_variance, covariance[2, 2])
                found.seen["camera correction"] += defence.corrected
