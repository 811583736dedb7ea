"""Benign runs for training: traffic is simulated once and then sensed with every profile and matching."""

from pathlib import Path

import numpy as np

from gpsec.association.associating import Associating
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table, concatenated, taken
from gpsec.core.threads import Threads
from gpsec.detection.logs import ResidualLog
from gpsec.detection.monitor_state import MonitorInputs
from gpsec.detection.pairing import Pending
from gpsec.detection.residual import Residuals
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, load_map
from gpsec.pipeline.build import sampling_of
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.loop_settings import LoopSettings
from gpsec.pipeline.mismatch import look_by_place
from gpsec.sensors.profiles import SensorProfile, residual_sigma_m
from gpsec.sensors.sense import Sensors
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.sensors.tapes import NO_TAPES, Tapes
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import RecordedTraffic, Recording, record_traffic
from gpsec.traffic.recordingfile import load_recording, on_net, save_recording
from gpsec.traffic.session import SumoSession
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


def record_scenario(sumocfg: Path, seed: int, target: Path) -> None:
    """Simulate a scenario with every road vehicle equipped, and keep the truth in the file `target`."""
    options = resolve_options(sumocfg, seed=seed)
    hd_map = load_map(options.net_file, ())
    with SumoSession(options, hd_map.lane_index, lambda departure: True) as session:
        recording = record_traffic(session, None)
    save_recording(recording, target, on_net(options.net_file, len(hd_map.lane_ids)))


def recorded_traffic(path: Path, net_file: Path) -> Recording:
    """Return the recording at `path`, which has to be one of the net `net_file`.

    Raises:
        GpsecError: it is not, or is damaged; see `load_recording`.
    """
    return load_recording(path, on_net(net_file, len(load_map(net_file, ()).lane_ids)))


class _ResidualOnly:
    """An engine that stops at the residual and keeps it; implements `gpsec.types.method.Method`."""

    def __init__(self, hd_map: HDMap, profile: SensorProfile, association: str, step_s: float, watched: bool) -> None:
        self._answers = Table(Answers, detectors=0, defences=1)
        layer = np.array([hd_map.layer(profile.map_spacing_m)], np.int32)
        noise = noise_table([filter_noise(profile, step_s)])
        self._association = Associating(association, hd_map.roads(layer), noise, step_s)
        self._lanes = self._association.new_state(1)
        view = MapView(hd_map.lanes, hd_map.index, self._association.mode, layer)
        self._residuals = Residuals(view, sampling_of([profile], step_s))
        self._pending = Table(Pending)
        self._watched = watched
        self.parts: list[tuple[np.ndarray, ...]] = []
        self.inputs: list[MonitorInputs] = []
        self._life: dict[int, int] = {}
        self._lives = 0

    @property
    def answers(self) -> Answers:
        """What was found in the last step."""
        return self._answers.now

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        self._answers.grow(capacity)
        self._lanes.grow(capacity)
        self._pending.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Let `rows` stand for new vehicles."""
        self._lanes.reset(rows)
        self._pending.reset(rows)
        for row in rows.tolist():
            self._life[row] = self._lives
            self._lives += 1

    def copy(self, source: Ints, target: Ints) -> None:
        """Do nothing: nobody is attacked."""

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
        """Form the residuals and keep what a detector would be given."""
        self._association.update(self._lanes.now, rows, tracks, vehicles, seen, threads)
        self._residuals.update(number, self._pending.now, rows, tracks, vehicles, seen, threads)
        vehicle = tracks.vehicle[rows]
        if self._watched:
            fix_m = tracks.fix_m[rows]
            handed = MonitorInputs(
                fix_east_m=fix_m[:, 0],
                fix_north_m=fix_m[:, 1],
                fix_valid=tracks.fix_valid[rows],
                heading_rad=seen.heading_rad[vehicle],
                yaw_rate_rps=seen.yaw_rate_rps[vehicle],
                lane=self._pending.now.lane[rows],
                sees_lane=seen.camera_valid[vehicle] & tracks.lane_known[rows],
                unmatched=tracks.unmatched[rows],
            )
            self.inputs.append(handed)
        self.parts.append(
            (
                np.array([self._life[row] for row in rows.tolist()], np.int32),
                np.full(len(rows), number, np.int32),
                tracks.residual_m[rows],
                tracks.residual_valid[rows],
                seen.speed_mps[vehicle],
                self._pending.now.curvature_per_m[rows],
                self._pending.now.sigma_m[rows],
            )
        )


def residual_log(
    recording: Recording,
    net_file: Path,
    network: str,
    profile: SensorProfile,
    association: str,
    seed: int,
    watched: bool = False,
    tapes: Tapes = NO_TAPES,
) -> ResidualLog:
    """Return the residuals that vehicles of one profile would have seen in recorded traffic, without an attack.

    If they are `watched`, what the monitor is handed is in the log, too. `tapes` are played by their sensors.
    """
    source = RecordedTraffic(recording)
    hd_map = load_map(net_file, (profile.map_spacing_m,))
    method = _ResidualOnly(hd_map, profile, association, source.step_s, watched)
    sensors = Sensors((profile,), source.step_s, tapes=tapes)
    shared = SharedErrors(sensors, seed)
    visible, _ = look_by_place([profile.camera.visibility == "place" and tapes.camera is None], hd_map, net_file)
    settings = LoopSettings(
        seed=seed,
        step_s=source.step_s,
        origin_s=float(recording.time_s[0]) if len(recording) else 0.0,
        settle_s=0.0,
        hd_map=hd_map,
        sensors=sensors,
        shared=None if shared.is_quiet else shared,
        visibility=visible,
        profile_of=lambda departure: 0,
    )
    loop = Loop(settings, (), method)
    for frame in source.frames(None):
        loop.step(frame)
    columns = [np.concatenate(column) for column in zip(*method.parts, strict=True)]
    order = np.lexsort((columns[1], columns[0])).astype(np.int32)
    vehicle, step, residual, valid, speed, curvature, sigma = (column[order] for column in columns)
    return ResidualLog(
        network=network,
        profile=profile.name,
        association=association,
        step_s=source.step_s,
        scale_m=residual_sigma_m(profile),
        vehicle=vehicle,
        step=step,
        residual_m=residual,
        valid=valid,
        speed_mps=speed,
        curvature_per_m=curvature,
        camera_sigma_m=sigma,
        inputs=taken(concatenated(method.inputs), order) if method.inputs else None,
        figures=filter_noise(profile, source.step_s) if watched else None,
    )
