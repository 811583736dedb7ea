"""What comes before filters, one track after another: its lane, its residuals, its monitor and its detectors."""

from copy import deepcopy
from dataclasses import dataclass, replace

from gpsec.association.associating import Associating
from gpsec.detection.base import Detection
from gpsec.filters.noise import noise_of
from gpsec.hdmap.map import HDMap
from gpsec.localization.world import World
from gpsec.reference.association import TrackAssociation
from gpsec.reference.detector import Scale, TrackDetector, TrackVerdict
from gpsec.reference.detectors import detector_maker
from gpsec.reference.lane_line import LaneLines
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.monitor import MonitorSettings, TrackMonitor
from gpsec.reference.pairing import Pair, Pairing, Residual
from gpsec.reference.sight import Sight
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# As `gpsec.hdmap.search` numbers it.
_TRACKED_MODE = 0


@dataclass
class TrackPerception:
    """One vehicle under one attack plan.

    Attributes:
        lanes: which lane it is on, None where vehicles do not track it.
        pairing: what is compared with what.
        monitor: what watches its fixes, if a detector reads it.
        detectors: those of the run, in their order.

    """

    lanes: TrackAssociation | None
    pairing: Pairing
    monitor: TrackMonitor | None
    detectors: list[TrackDetector]

    def copied(self) -> "TrackPerception":
        """Return a track that goes on from where this one is."""
        return deepcopy(self)


@dataclass(frozen=True)
class Perceived:
    """What a track has seen in a step: sensor data with its lane, a residual, if any, and what detectors say."""

    sight: Sight
    residual: Residual | None
    verdicts: list[TrackVerdict]


class ReferencePerception:
    """Makes tracks and takes their steps.

    Attributes:
        matchers: the map of each sensor profile.

    """

    def __init__(self, hd_map: HDMap, world: World, association: Associating, detection: Detection) -> None:
        """Prepare for tracks.

        Raises:
            GpsecError: there is no reference of a detector.

        """
        self._world = world
        self._association = association
        self._detection = detection
        layers = world.hd_map.layer.tolist()
        matchers = {layer: LaneMatcher(hd_map, layer, world.hd_map.mode == _TRACKED_MODE) for layer in set(layers)}
        self.matchers = [matchers[layer] for layer in layers]
        lines = {layer: LaneLines(hd_map, layer) for layer in set(layers)}
        self._lines = [lines[layer] for layer in layers]
        self._make_detector = [detector_maker(detector, len(layers)) for detector in detection.detectors]

    def new_track(self, profile: int) -> TrackPerception:
        """Return a track of a sensor profile that has seen nothing."""
        detection, step_s = self._detection, self._world.step_s
        detectors = [
            make(Scale(profile, float(detection.scale_m[profile]), float(threshold), step_s))
            for make, threshold in zip(self._make_detector, detection.thresholds[profile], strict=True)
        ]
        sampling = detection.sampling
        pairing = Pairing(sampling.step_s, int(sampling.fix_steps[profile]), int(sampling.camera_steps[profile]))
        lanes = None
        if self._association.kind == "tracked":
            noise = noise_of(self._association.noise, profile)
            lanes = TrackAssociation(self._lines[profile], noise, step_s)
        monitor = None
        if (rules := detection.monitor) is not None:
            noise = noise_of(rules.noise, profile)
            settings = MonitorSettings(noise, rules.step_s, float(rules.gate[profile]), rules.cap, rules.learns_below)
            monitor = TrackMonitor(settings)
        return TrackPerception(lanes, pairing, monitor, detectors)

    def step(
        self, number: int, track: TrackPerception, row: int, tracks: Tracks, vehicles: Vehicles, seen: Measurements
    ) -> Perceived:
        """Take step `number` of a track, whose lane and residual are written to `row` of `tracks`."""
        vehicle = int(tracks.vehicle[row])
        profile = int(vehicles.profile[vehicle])
        sight = self._with_lane(track, row, vehicle, tracks, vehicles, sight_of(row, vehicle, tracks, seen))
        pair = track.pairing.step(number, sight)
        residual, seen_lane = None, -1
        if pair is not None:
            residual = self._residual(row, pair, profile, tracks)
            lane = pair.sight
            seen_lane = lane.lane
            sight = replace(sight, curvature_per_m=lane.curvature_per_m, camera_sigma_m=lane.camera_sigma_m)
        tracks.residual_valid[row] = residual is not None
        residual_m = None if residual is None else residual.z_m
        tracks.residual_m[row] = residual_m or 0.0
        if residual is not None:
            tracks.paired_m[row] = residual.fix_m
        if track.monitor is not None:
            sight = replace(sight, unmatched=bool(tracks.unmatched[row]))
            sight = replace(sight, told=track.monitor.step(number, sight, residual_m, seen_lane))
        attacked = bool(tracks.attacked[row])
        return Perceived(sight, residual, [one.step(sight, residual_m, attacked) for one in track.detectors])

    def _with_lane(
        self, track: TrackPerception, row: int, vehicle: int, tracks: Tracks, vehicles: Vehicles, sight: Sight
    ) -> Sight:
        """Return the sight with the lane that the track believes to be on, without the camera where it has no idea."""
        lanes = track.lanes
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
        on_map = self.matchers[profile].match(x, y, pair.sight.heading_rad, pair.sight.lane)
        if on_map is None:
            tracks.unmatched[row] = True
            return None
        if self._association.kind == "nearest":
            tracks.lane[row] = on_map.lane
        return Residual(pair.offset_m - on_map.offset_m, pair.now_m)


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
