"""Real traffic, recorded once, driven through both engines side by side."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from sklearn.ensemble import IsolationForest as SklearnForest

from gpsec.attacks.plans import plan_config
from gpsec.attacks.schedule import build_plans
from gpsec.detection.base import Detection
from gpsec.detection.bounds import Never, Told
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.forest_training import flatten
from gpsec.detection.innovation import Innovation
from gpsec.detection.isolation_forest import WINDOW, IsolationForest
from gpsec.detection.joint import Joint
from gpsec.detection.learned import Learned
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cell import HIDDEN, INPUTS, OUTPUTS
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import LstmGlr
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.separation import Separation
from gpsec.localization.rejoin import SwitchSettings
from gpsec.localization.responses import (
    CameraUkf,
    ConsiderUkf,
    DeadReckoning,
    Gate,
    NoResponse,
    Rollback,
    Ukf5,
    Ukf5Rollback,
)
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.pipeline.build import Ground, lay_ground, sampling_of
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.loop_settings import LoopSettings
from gpsec.pipeline.probing import target_columns
from gpsec.scenario import load_scenario
from gpsec.sensors.profiles import residual_sigma_m
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.recording import Recording, record_traffic
from gpsec.traffic.session import SumoSession
from gpsec.traffic.source import Frame
from gpsec.types.method import Method

SCENARIOS = Path(__file__).parents[2] / "scenarios"
WINDOW_S = {"start_after_s": [0.0, 4.0], "duration_s": [6.0, 10.0], "share": 1.0}
ATTACKS: list[dict[str, object]] = [
    {"attack": "constant_bias", "bias_m": 1.2},
    {"attack": "stealth", "gamma_m": 0.02, "delta": 1.05},
    {"attack": "jamming"},
    {"attack": "noise", "sigma_m": 3.0},
    {"attack": "lane_alias"},
]
DEFENCES = (
    ("never", NoResponse),
    ("never", Gate),
    ("told", CameraUkf),
    ("chi_square", CameraUkf),
    ("cusum", DeadReckoning),
    ("isolation_forest", CameraUkf),
    ("lstm_glr", DeadReckoning),
    ("isolation_forest", Rollback),
    ("isolation_forest", ConsiderUkf),
    ("chi_square", Ukf5),
    ("cusum", Ukf5Rollback),
)


@dataclass(frozen=True)
class Drive:
    """Recorded traffic on the ground that it was recorded on."""

    ground: Ground
    recording: Recording

    def associated(self, kind: str) -> "Drive":
        """The same traffic, for vehicles that know their lane in another way."""
        ground = self.ground
        association = replace(ground.association, kind=kind)
        world = ground.world._replace(hd_map=ground.world.hd_map._replace(mode=association.mode))
        return replace(self, ground=replace(ground, world=world, association=association))

    def few(self, vehicles: int) -> Iterator[Frame]:
        """Yield the recorded frames as if only the first vehicles to depart were equipped."""
        chosen = set(self.recording.vehicle_id[:vehicles].tolist())
        rows: set[int] = set()
        for number in range(len(self.recording)):
            frame = self.recording.frame(number)
            left = [row for row in frame.left if row in rows]
            departures = [departure for departure in frame.departures if departure.vehicle_id in chosen]
            rows = rows.difference(left).union(departure.row for departure in departures)
            here = np.isin(frame.rows, list(rows))
            yield replace(
                frame,
                left=left,
                departures=departures,
                rows=frame.rows[here],
                front_m=frame.front_m[here],
                lane=frame.lane[here],
            )


def record_drive(
    name: str, duration_s: float, step_s: float = 0.1, profiles: Sequence[str] = ("carla", "nuscenes", "dsd")
) -> Drive:
    scenario = load_scenario(SCENARIOS / name)
    fleet = scenario.fleet.model_copy(update={"profile": dict.fromkeys(profiles, 1.0 / len(profiles))})
    traffic = scenario.traffic.model_copy(update={"step_s": step_s})
    ground = lay_ground(scenario.model_copy(update={"fleet": fleet, "traffic": traffic}))
    with SumoSession(ground.options, ground.hd_map.lane_index, lambda departure: True) as session:
        return Drive(ground, record_traffic(session, duration_s))


def learned_for(seed: int) -> dict[str, Learned]:
    """What the detectors might have learned on a profile: a forest by scikit-learn, a network of random weights."""
    whitening = {"white": 0.6 + 0.1 * seed, "slow": 0.8 - 0.1 * seed, "tau_s": 20.0 + 10.0 * seed}
    return {
        "cusum": {key: np.asarray(value) for key, value in whitening.items()},
        "isolation_forest": _forest(seed),
        "lstm": _network(seed, Lstm.outputs),
        "lstm_glr": _network(seed, OUTPUTS),
    }


def detection_for(world: World, profiles: Sequence[str]) -> Detection:
    """Detectors that differ between profiles."""
    learned = [learned_for(seed) for seed in range(len(profiles))]
    detectors = (
        ChiSquare(),
        Cusum.from_learned([one["cusum"] for one in learned]),
        IsolationForest.from_learned([one["isolation_forest"] for one in learned]),
        Lstm.from_learned([one["lstm"] for one in learned]),
        LstmGlr.from_learned([one["lstm_glr"] for one in learned]),
        LstmCusum.from_learned([one["lstm_glr"] for one in learned]),
        Innovation(),
        Joint(),
        Separation(),
        Never(),
        Told(),
    )
    gates = np.array([35.0, 41.0, 50.0])[: len(profiles)]
    return Detection(
        names=tuple(detector.name for detector in detectors),
        rates=tuple("" if detector.name in ("never", "told") else "0.1/h" for detector in detectors),
        origins=tuple("counted" for _ in detectors),
        detectors=detectors,
        thresholds=np.tile([4.0, 6.0, 0.62, 4.0, 4.0, 6.0, 20.0, 24.0, 30.0, 0.5, 0.5], (len(profiles), 1)),
        scale_m=np.array([residual_sigma_m(PROFILES[name]) for name in profiles]),
        sampling=sampling_of([PROFILES[name] for name in profiles], world.step_s),
        monitor=MonitorRules(world.step_s, world.noise, gates, *PRESETS["R2"]),
    )


def _forest(seed: int) -> Learned:
    windows = np.abs(np.random.default_rng(seed).normal(size=(800, WINDOW)))
    features = np.concatenate([windows, windows.mean(axis=1, keepdims=True)], axis=1).astype(np.float32)
    return flatten(SklearnForest(n_estimators=20, max_samples=128, random_state=seed).fit(features))


def _network(seed: int, outputs: int) -> Learned:
    generator = np.random.default_rng(seed)

    def weights(*shape: int):
        return generator.normal(scale=0.3, size=shape).astype(np.float32)

    return {
        "weight": weights(len(INPUTS) + HIDDEN, 4 * HIDDEN),
        "bias": weights(4 * HIDDEN),
        "head": weights(HIDDEN, outputs),
        "offset": weights(outputs),
    }


def localization_for(ground: Ground, detection: Detection) -> Localization:
    responses = {kind: kind() for _, kind in DEFENCES}
    columns = np.array([detection.names.index(detector) for detector, _ in DEFENCES], np.int32)
    return Localization(columns, [responses[kind] for _, kind in DEFENCES], ground.world, SwitchSettings())


def drive_through(drive: Drive, vehicles: int, method: Method, attacks: Sequence[dict[str, object]] = ATTACKS) -> None:
    """Run the first vehicles of the recorded traffic through `method`, each under every attack."""
    ground = drive.ground
    plans = build_plans([plan_config(table | WINDOW_S, "parity") for table in attacks])
    settings = LoopSettings(
        seed=11,
        step_s=ground.options.step_s,
        origin_s=ground.options.begin_s + ground.options.step_s,
        settle_s=1.0,
        hd_map=ground.hd_map,
        sensors=ground.sensors,
        profile_of=lambda departure: departure.row % len(ground.choice.profiles),
        targets=target_columns(detection_for(ground.world, ground.choice.profiles), plans),
    )
    loop = Loop(settings, plans, method)
    for frame in drive.few(vehicles):
        loop.step(frame)
