"""Perfect sensors, and profiles that differ from them in what a test looks at."""

from dataclasses import dataclass, field

import numpy as np

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.sensors.profiles import Camera, Gnss, Gyro, Heading, Odometer, SensorProfile
from gpsec.sensors.sense import Sensors
from gpsec.sensors.state import SensorState
from gpsec.types.vehicles import Measurements, Vehicles

STEP_S = 0.1
_ALWAYS = {"rate_hz": 1000.0, "latency_s": 0.0, "outages_per_h": 0.0, "outage_mean_s": 0.0}
_EXACT = {
    "gnss": (Gnss, {"white_m": 0.0, "bias_m": 0.0, "bias_tau_s": 100.0}),
    "gyro": (Gyro, {"angle_random_walk_deg_per_sqrt_h": 0.0, "bias_deg_per_h": 0.0, "bias_tau_s": 100.0}),
    "odometer": (Odometer, {"white_mps": 0.0, "scale_ratio": 0.0}),
    "heading": (Heading, {"white_deg": 0.0, "bias_deg": 0.0, "bias_tau_s": 100.0}),
    "camera": (
        Camera,
        {
            "white_m": 0.0,
            "bias_m": 0.0,
            "bias_tau_s": 100.0,
            "mount_m": 0.0,
            "range_m": 50.0,
            "field_of_view_deg": 60.0,
            "trust_limit_m": 10.0,
        },
    ),
}


def profile(name: str = "exact", **changes: dict[str, float]) -> SensorProfile:
    """Return perfect sensors, save for the figures in `changes`, by channel."""
    channels = {}
    for channel, (kind, figures) in _EXACT.items():
        values = _ALWAYS | figures | changes.get(channel, {})
        channels[channel] = kind(**values, sources=dict.fromkeys(values, "chosen by a test"))
    return SensorProfile(
        name=name, title="test", map_spacing_m=1.0, sources={"map_spacing_m": "chosen by a test"}, **channels
    )


@dataclass
class Drive:
    """`count` vehicles with one profile each way of standing still at the origin, until a test moves them."""

    profiles: tuple[SensorProfile, ...]
    count: int = 1
    seed: int = 1
    step_s: float = STEP_S
    sensors: Sensors = field(init=False)
    state: Table[SensorState] = field(init=False)
    step: int = field(init=False, default=-1)

    def __post_init__(self) -> None:
        self.sensors = Sensors(self.profiles, self.step_s)
        self._vehicles, self._measurements = Table(Vehicles, self.count), Table(Measurements, self.count)
        self.state = self.sensors.new_state(self.count)
        self.tables = [self.state, self._vehicles, self._measurements]
        self.vehicles.key[:] = np.random.default_rng(self.seed).integers(0, 2**63, self.count).astype(np.uint64)
        self.vehicles.profile[:] = np.arange(self.count) % len(self.profiles)
        self.vehicles.marked[:] = True
        self.rows = np.arange(self.count, dtype=np.int32)
        self.sensors.enter(self.state, self.vehicles, self.rows, 0)

    @property
    def vehicles(self) -> Vehicles:
        """The truth."""
        return self._vehicles.now

    @property
    def measurements(self) -> Measurements:
        """What was sensed last."""
        return self._measurements.now

    def sense(self, rows: np.ndarray | None = None, threads: Threads | None = None) -> Measurements:
        """Take one step with the truth as it is."""
        self.step += 1
        chosen = self.rows if rows is None else rows
        self.sensors.sense(self.state, self.vehicles, self.measurements, chosen, self.step, threads or Threads(1))
        return self.measurements

    def move(self, speed_mps: float, yaw_rate_rps: float) -> None:
        """Move every vehicle along an exact arc for one step."""
        v = self.vehicles
        turn = yaw_rate_rps * self.step_s
        chord = speed_mps * self.step_s if turn == 0.0 else 2.0 * speed_mps / yaw_rate_rps * np.sin(turn / 2.0)
        middle = v.yaw_rad + turn / 2.0
        v.rear_m[:] += chord * np.stack([np.cos(middle), np.sin(middle)], axis=1)
        v.yaw_rad[:] = v.yaw_rad + turn
        v.speed_mps[:] = speed_mps
        v.yaw_rate_rps[:] = yaw_rate_rps
