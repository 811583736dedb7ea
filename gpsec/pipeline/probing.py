"""What detectors would say of fixes that an attacker might send: it tries them on copies of what tracks remember."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gpsec.association.associating import Associating
from gpsec.attacks.probing import Probed, Question
from gpsec.attacks.schedule import Plan
from gpsec.core.arrays import Floats, Ints
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table, taken
from gpsec.detection.base import Detection, Detector
from gpsec.localization.world import World
from gpsec.pipeline.exact import sense_exactly
from gpsec.pipeline.perception import Perception, StepInputs
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Copies that are tried together; more would not stay in the caches of a processor.
_TOGETHER = 4096
# What the attacker's own track has in common with that of the vehicle.
_COMMON = ("vehicle", "plan", "settled", "attacked", "start_step", "end_step", "fix_valid")


def target_columns(detection: Detection, plans: Sequence[Plan]) -> dict[str, Ints]:
    """Return the columns of the operating points that the attackers of plans look at, by the name of the plan.

    Raises:
        GpsecError: one is none of the run, or the run has none.
    """
    points = zip(detection.names, detection.detectors, strict=True)
    usable = {
        name: k
        for k, (name, detector) in enumerate(points)
        if isinstance(detector, Detector) and np.isfinite(detection.thresholds[:, k]).all()
    }
    found = {}
    for plan in plans:
        if (known := plan.attack.known()) is None:
            continue
        where = f"plan '{shown(plan.name)}': target"
        for target in known.targets:
            if target not in usable:
                raise GpsecError(
                    f"{where}: no detector of the run is called '{shown(target)}'; {nearest(target, usable)}"
                )
        if not usable:
            raise GpsecError(f"{where}: expected a detector in the run, found none")
        found[plan.name] = np.array([usable[target] for target in known.targets or usable], np.int32)
    return found


class Probing:
    """Tries fixes in rows of its own, and leaves those of the run alone.

    An attacker who has a copy of the detectors follows every track with it, fed with sensors that have no errors.
    """

    def __init__(self, world: World, association: Associating, detection: Detection, *, copies: bool = False) -> None:
        """Begin without rows; with `copies` if an attacker has one."""
        self._parts = world, association, detection
        self._detection = detection
        self._scratch: dict[tuple[int, ...], tuple[Perception, Table[Tracks]]] = {}
        self._own = Perception(world, association, detection) if copies else None
        self._own_tracks = Table(Tracks)
        self._exact = Table(Measurements)

    def tables(self) -> list[Table[Any]]:
        """Return all that is remembered of track rows."""
        return [] if self._own is None else [self._own_tracks, *self._own.tables()]

    def follow(self, rows: Ints, inputs: StepInputs) -> None:
        """Take a step of some track rows with the attacker's own copy, if there is one."""
        if self._own is None:
            return
        _, tracks, vehicles, seen, _ = inputs
        exact, own, vehicle = self._exactly(tracks.vehicle[rows], vehicles, seen), self._own_tracks.now, tracks.vehicle
        for name in _COMMON:
            getattr(own, name)[rows] = getattr(tracks, name)[rows]
        moved_m = tracks.fix_m[rows] - seen.fix_m[vehicle[rows]]
        own.fix_m[rows] = exact.fix_m[vehicle[rows]] + np.where(tracks.fix_valid[rows, np.newaxis], moved_m, 0.0)
        self._own.step(rows, inputs._replace(tracks=own, seen=exact), Stopwatch())

    def ask(self, asked: Question, perception: Perception, inputs: StepInputs) -> Probed:
        """Return what would be found of the fixes in a step that `perception` has not taken yet."""
        _, tracks, vehicles, seen, _ = inputs
        if asked.own_copy:
            if self._own is None:
                raise ValueError("expected a method with copies for an attacker who asks its own")
            perception = self._own
            seen = self._exactly(tracks.vehicle[asked.rows], vehicles, seen)
            tracks = self._own_tracks.now
        m, tried = asked.moved_m.shape[:2]
        found = Probed(np.zeros((m, tried)), np.zeros((m, tried), np.bool_))
        columns = asked.columns
        for first in range(0, m, max(1, _TOGETHER // tried)):
            part = slice(first, first + max(1, _TOGETHER // tried))
            some = asked._replace(rows=asked.rows[part], moved_m=asked.moved_m[part])
            scratch, copies = self._scratch_for(columns)
            rows = self._begin(some, scratch, copies, perception, tracks, seen)
            scratch.step(rows, inputs._replace(tracks=copies.now, seen=seen), Stopwatch())
            threshold = self._detection.thresholds[vehicles.profile[copies.now.vehicle[rows]]][:, columns]
            ratio, scored = _ratio(scratch, rows, columns, threshold)
            found.ratio[part], found.scored[part] = ratio.reshape(-1, tried), scored.reshape(-1, tried)
        return found

    def _begin(
        self,
        asked: Question,
        scratch: Perception,
        copies: Table[Tracks],
        perception: Perception,
        tracks: Tracks,
        seen: Measurements,
    ) -> Ints:
        """Copy each track as often as it is tried, each with its fix; return the rows."""
        source = np.repeat(asked.rows, asked.moved_m.shape[1])
        scratch.take(perception, source)
        copies.grow(len(source))
        for name, values in taken(tracks, source)._asdict().items():
            getattr(copies.now, name)[: len(source)] = values
        rows = np.arange(len(source), dtype=np.int32)
        vehicle = tracks.vehicle[source]
        copies.now.fix_m[rows] = seen.fix_m[vehicle] + asked.moved_m.reshape(-1, 2)
        copies.now.fix_valid[rows] = seen.fix_valid[vehicle]
        return rows

    def _scratch_for(self, columns: Ints) -> tuple[Perception, Table[Tracks]]:
        key = tuple(columns.tolist())
        if key not in self._scratch:
            self._scratch[key] = Perception(*self._parts, only=key), Table(Tracks)
        return self._scratch[key]

    def _exactly(self, vehicle: Ints, vehicles: Vehicles, seen: Measurements) -> Measurements:
        self._exact.grow(len(vehicles.key))
        sense_exactly(np.unique(vehicle), vehicles, seen, self._exact.now)
        return self._exact.now


def _ratio(scratch: Perception, rows: Ints, columns: Ints, threshold: Floats) -> tuple[Floats, Any]:
    """Return (n,) the largest statistic over its threshold, and whether anything is scored."""
    statistic = scratch.answers.statistic[rows][:, columns]
    scored = scratch.answers.scored[rows][:, columns]
    over = np.where(statistic > threshold, np.inf, 0.0)
    ratio = np.divide(statistic, threshold, out=over, where=threshold > 0.0)
    return np.where(scored, ratio, 0.0).max(axis=1), scored.any(axis=1)
