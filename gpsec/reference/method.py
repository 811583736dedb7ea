"""The reference engine: lanes, residual, detectors and filters of one track after another."""

from copy import deepcopy
from dataclasses import replace

from gpsec.association.associating import Associating
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detection
from gpsec.filters.noise import noise_of
from gpsec.hdmap.map import HDMap
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.reference.association import TrackAssociation
from gpsec.reference.detector import Scale, TrackDetector
from gpsec.reference.detectors import detector_maker
from gpsec.reference.history import Rules
from gpsec.reference.lane_line import LaneLines
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.monitor import MonitorSettings, TrackMonitor
from gpsec.reference.pairing import Pair, Pairing, Residual
from gpsec.reference.sight import Sight
from gpsec.reference.switch import TrackLocalization
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# As `gpsec.hdmap.search` numbers it.
_TRACKED_MODE = 0


class ReferenceTrack:
    """One vehicle under one attack plan: its detectors and its filters.

    Attributes:
        lanes: which lane it is on, None where vehicles do not track it.
        pairing: what is compared with what.
        monitor: what watches its fixes, if a detector reads it.
        detectors: those of the run, in their order.
        localization: the filters of all defences.

    """

    def __init__(
        self,
        lanes: TrackAssociation | None,
        pairing: Pairing,
        monitor: TrackMonitor | None,
        detectors: list[TrackDetector],
        localization: TrackLocalization,
    ) -> None:
        self.lanes = lanes
        self.pairing = pairing
        self.monitor = monitor
        self.detectors = detectors
        self.localization = localization


class ReferenceMethod:
    """One plain object for each track, by hand from filterpy, shapely and torch.

    Implements `gpsec.types.method.Method`.
    """

    def __init__(
        self,
        hd_map: HDMap,
        world: World,
        association: Associating,
        detection: Detection,
        localization: Localization,
    ) -> None:
        """Prepare for tracks.

        Raises:
            GpsecError: there is no reference of a detector or response.

        """
        self._world = world
        self._association = association
        self._detection = detection
        self._localization = localization
        self._profiles = len(world.hd_map.layer)
        matchers = {
            layer: LaneMatcher(hd_map, layer, world.hd_map.mode == _TRACKED_MODE)
            for layer in set(world.hd_map.layer.tolist())
        }
        self._matchers = [matchers[layer] for layer in world.hd_map.layer.tolist()]
        lines = {layer: LaneLines(hd_map, layer) for layer in set(world.hd_map.layer.tolist())}
        self._lines = [lines[layer] for layer in world.hd_map.layer.tolist()]
        self._make_detector = [detector_maker(detector, self._profiles) for detector in detection.detectors]
        self._tracks: dict[int, ReferenceTrack] = {}
        self._new_localization(0)  # says now, rather than with the first vehicle, what is missing
        lengths = {"detectors": len(detection.names), "defences": len(localization.responses)}
        self._answers = Table(Answers, **lengths)

    @property
    def answers(self) -> Answers:
        """The results of the last step."""
        return self._answers.now

    def track(self, row: int) -> ReferenceTrack:
        """Return the object of a track row in use, for comparisons."""
        return self._tracks[row]

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        self._answers.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Reset the track rows `rows`."""
        self._answers.reset(rows)
        for row in rows.tolist():
            self._tracks.pop(row, None)

    def copy(self, source: Ints, target: Ints) -> None:
        """Copy the state of the tracks `source` to the tracks `target`."""
        self._answers.copy(source, target)
        for one, other in zip(source.tolist(), target.tolist(), strict=True):
            self._tracks.pop(other, None)
            if one in self._tracks:
                self._tracks[other] = deepcopy(self._tracks[one])

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
        """Take step `number` of the track rows `rows`, one after another; `threads` are not used."""
        for row in rows.tolist():
            vehicle = int(tracks.vehicle[row])
            profile = int(vehicles.profile[vehicle])
            if row not in self._tracks:
                self._tracks[row] = self._new_track(profile)
            sight = self._with_lane(row, vehicle, tracks, vehicles, sight_of(row, vehicle, tracks, seen))
            pair = self._tracks[row].pairing.step(number, sight)
            residual, seen_lane = None, -1
            if pair is not None:
                residual = self._residual(row, pair, profile, tracks)
                lane = pair.sight
                seen_lane = lane.lane
                sight = replace(sight, curvature_per_m=lane.curvature_per_m, camera_sigma_m=lane.camera_sigma_m)
            tracks.residual_valid[row] = residual is not None
            tracks.residual_m[row] = 0.0 if residual is None else residual.z_m
            if residual is not None:
                tracks.paired_m[row] = residual.fix_m
            monitor = self._tracks[row].monitor
            if monitor is not None:
                residual_m = None if residual is None else residual.z_m
                sight = replace(sight, unmatched=bool(tracks.unmatched[row]))
                sight = replace(sight, told=monitor.step(number, sight, residual_m, seen_lane))
            self._answer(row, sight, residual, bool(tracks.attacked[row]), profile)
        watch.lap("reference engine")

    def _with_lane(self, row: int, vehicle: int, tracks: Tracks, vehicles: Vehicles, sight: Sight) -> Sight:
        """Return the sight with the lane that the track believes to be on, without the camera where it has no idea."""
        lanes = self._tracks[row].lanes
        if lanes is None:
            tracks.lane_known[row], tracks.unmatched[row] = True, False
            if self._association.kind == "oracle":
                tracks.lane[row] = vehicles.camera_lane[vehicle]
        else:
            lanes.step(sight)
            tracks.lane[row] = -1 if lanes.best is None else lanes.best
            tracks.lane_known[row], tracks.unmatched[row] = lanes.known, lanes.unmatched
        if not tracks.lane_known[row]:
            return replace(sight, lane_offset_m=None)
        return replace(sight, lane=int(tracks.lane[row]))

    def _residual(self, row: int, pair: Pair, profile: int, tracks: Tracks) -> Residual | None:
        """Return z = d_camera - d_map(fix); None where there is no match, which is said in `tracks`."""
        x, y = pair.fix_m.tolist()
        on_map = self._matchers[profile].match(x, y, pair.sight.heading_rad, pair.sight.lane)
        if on_map is None:
            tracks.unmatched[row] = True
            return None
        if self._association.kind == "nearest":
            tracks.lane[row] = on_map.lane
        return Residual(pair.offset_m - on_map.offset_m, pair.now_m)

    def _answer(self, row: int, sight: Sight, residual: Residual | None, attacked: bool, profile: int) -> None:
        track, answers = self._tracks[row], self.answers
        residual_m = None if residual is None else residual.z_m
        for k, detector in enumerate(track.detectors):
            verdict = detector.step(sight, residual_m, attacked)
            answers.statistic[row, k] = verdict.statistic
            answers.scored[row, k] = verdict.scored
            answers.alarm[row, k] = verdict.alarm
        track.localization.step(sight, answers.alarm[row].tolist(), residual, self._matchers[profile])
        for d, defence in enumerate(track.localization.defences):
            answers.estimate_m[row, d] = defence.position_m
            answers.isolated[row, d] = defence.isolated

    def _new_track(self, profile: int) -> ReferenceTrack:
        detection = self._detection
        detectors = [
            make(Scale(profile, float(detection.scale_m[profile]), float(threshold), self._world.step_s))
            for make, threshold in zip(self._make_detector, detection.thresholds[profile], strict=True)
        ]
        sampling = detection.sampling
        pairing = Pairing(sampling.step_s, int(sampling.fix_steps[profile]), int(sampling.camera_steps[profile]))
        lanes = None
        if self._association.kind == "tracked":
            noise = noise_of(self._association.noise, profile)
            lanes = TrackAssociation(self._lines[profile], noise, self._world.step_s)
        monitor = None
        if (rules := detection.monitor) is not None:
            noise = noise_of(rules.noise, profile)
            settings = MonitorSettings(noise, rules.step_s, float(rules.gate[profile]), rules.cap, rules.learns_below)
            monitor = TrackMonitor(settings)
        return ReferenceTrack(lanes, pairing, monitor, detectors, self._new_localization(profile))

    def _new_localization(self, profile: int) -> TrackLocalization:
        table, localization = self._world.noise, self._localization
        rules = Rules(noise_of(table, profile), localization.settings, self._world.step_s)
        return TrackLocalization(
            localization.detector.tolist(), [response.name for response in localization.responses], rules
        )


def sight_of(row: int, vehicle: int, tracks: Tracks, seen: Measurements) -> Sight:
    """Return what one track has from its sensors in this step, without a lane."""
    c0, c1, c2, _ = seen.lane_poly[vehicle].tolist()
    return Sight(
        fix_m=tracks.fix_m[row].copy() if tracks.fix_valid[row] else None,
        lane=-1,
        heading_rad=float(seen.heading_rad[vehicle]),
        speed_mps=float(seen.speed_mps[vehicle]),
        yaw_rate_rps=float(seen.yaw_rate_rps[vehicle]),
        lane_offset_m=-c0 if seen.camera_valid[vehicle] else None,
        lane_slope=c1,
        curvature_per_m=2.0 * c2,
        camera_sigma_m=float(seen.camera_sigma_m[vehicle]),
    )
