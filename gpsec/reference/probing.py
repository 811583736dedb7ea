"""What an attacker learns of detectors, track by track: copies of them try the fixes that it might send."""

from collections.abc import Mapping
from math import cos, inf, tan

import numpy as np

from gpsec.attacks.probing import Probed, Question
from gpsec.core.arrays import Ints
from gpsec.core.tables import Table, taken
from gpsec.detection.base import Detection
from gpsec.reference.perception import ReferencePerception, TrackPerception
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class OwnCopies:
    """Detectors of an attacker's own, which follow every track with sensors that have no errors.

    Attributes:
        tracks: what they take each track for.
        perceptions: by track row.

    """

    def __init__(self, perception: ReferencePerception) -> None:
        self._make = perception
        self._tracks = Table(Tracks)
        self.perceptions: dict[int, TrackPerception] = {}

    @property
    def tracks(self) -> Tracks:
        """What they take each track for."""
        return self._tracks.now

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        self._tracks.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        self._tracks.reset(rows)
        for row in rows.tolist():
            self.perceptions.pop(row, None)

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where the tracks `source` are."""
        self._tracks.copy(source, target)
        for one, other in zip(source.tolist(), target.tolist(), strict=True):
            self.perceptions.pop(other, None)
            if one in self.perceptions:
                self.perceptions[other] = self.perceptions[one].copied()

    def follow(self, number: int, rows: Ints, tracks: Tracks, vehicles: Vehicles, seen: Measurements) -> None:
        """Take step `number` of the track rows `rows`."""
        exact, own = without_errors(vehicles, seen), self.tracks
        for row in rows.tolist():
            vehicle = tracks.vehicle[row]
            own.vehicle[row], own.attacked[row] = vehicle, tracks.attacked[row]
            own.fix_valid[row] = tracks.fix_valid[row]
            if tracks.fix_valid[row]:
                own.fix_m[row] = vehicles.rear_m[vehicle] + (tracks.fix_m[row] - seen.fix_m[vehicle])
            if row not in self.perceptions:
                self.perceptions[row] = self._make.new_track(int(vehicles.profile[vehicle]))
            self._make.step(number, self.perceptions[row], row, own, vehicles, exact)


def without_errors(vehicles: Vehicles, seen: Measurements) -> Measurements:
    """Return what the sensors would give in this step without errors, whenever they do give something."""
    exact = Table(Measurements, len(vehicles.key)).now
    exact.fix_m[:], exact.fix_valid[:] = vehicles.rear_m, seen.fix_valid
    exact.speed_mps[:], exact.yaw_rate_rps[:] = vehicles.speed_mps, vehicles.yaw_rate_rps
    exact.heading_rad[:], exact.camera_valid[:] = vehicles.yaw_rad, seen.camera_valid
    exact.camera_sigma_m[:] = seen.camera_sigma_m
    for row in np.flatnonzero(seen.camera_valid):
        turn = float(np.remainder(vehicles.camera_yaw_rad[row] - vehicles.yaw_rad[row] + np.pi, 2.0 * np.pi) - np.pi)
        curvature, slope, c = vehicles.camera_curvature_per_m[row], tan(turn), cos(turn)
        exact.lane_poly[row] = (
            -vehicles.camera_offset_m[row] / c,
            slope,
            curvature / (2.0 * c**3),
            curvature**2 * slope / (2.0 * c**4),
        )
    return exact


class Trials:
    """Tries fixes on copies of tracks.

    Attributes:
        perception: takes their steps.
        detection: of the run.

    """

    def __init__(self, perception: ReferencePerception, detection: Detection) -> None:
        self._perception = perception
        self._detection = detection

    def ask(
        self,
        number: int,
        asked: Question,
        known: Mapping[int, TrackPerception],
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
    ) -> Probed:
        """Return what would be found of the fixes in step `number`, which the `known` tracks have not taken yet."""
        ratio, scored = np.zeros(asked.moved_m.shape[:2]), np.zeros(asked.moved_m.shape[:2], np.bool_)
        for i, row in enumerate(asked.rows.tolist()):
            vehicle = tracks.vehicle[row]
            threshold = self._detection.thresholds[vehicles.profile[vehicle]]
            for c, moved_m in enumerate(asked.moved_m[i]):
                one = taken(tracks, np.array([row]))
                one.fix_m[0], one.fix_valid[0] = seen.fix_m[vehicle] + moved_m, seen.fix_valid[vehicle]
                said = self._perception.step(number, known[row].copied(), 0, one, vehicles, seen).verdicts
                for k in asked.columns.tolist():
                    if said[k].scored:
                        scored[i, c] = True
                        ratio[i, c] = max(ratio[i, c], _ratio(said[k].statistic, float(threshold[k])))
        return Probed(ratio, scored)


def _ratio(statistic: float, threshold: float) -> float:
    if threshold > 0.0:
        return statistic / threshold
    return inf if statistic > threshold else 0.0
