"""A fleet whose truth is set by hand, with its sensors."""

from dataclasses import dataclass, field

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.sensors.mismatch import AS_STATED, Mismatch
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.sense import Sensors
from gpsec.sensors.state import SensorState
from gpsec.sensors.tapes import NO_TAPES, Tapes
from gpsec.testing.contract import STEP_S
from gpsec.types.vehicles import Measurements, Vehicles


@dataclass
class Drive:
    """Vehicles that stand at the origin, heading east, until somebody moves them.

    Attributes:
        profiles: which the vehicles have in turn.
        count: number of vehicles.
        seed: of their keys.
        step_s: length of a step.
        mismatch: by what the sensors differ from their data sheets.
        tapes: in the place of their noise.
        sensors, state: of the vehicles.
        step: number of the last step, -1 before the first.
    """

    profiles: tuple[SensorProfile, ...]
    count: int = 1
    seed: int = 1
    step_s: float = STEP_S
    mismatch: Mismatch = AS_STATED
    tapes: Tapes = NO_TAPES
    sensors: Sensors = field(init=False)
    state: Table[SensorState] = field(init=False)
    step: int = field(init=False, default=-1)

    def __post_init__(self) -> None:
        self.sensors = Sensors(self.profiles, self.step_s, self.mismatch, self.tapes)
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

    def sense(self, rows: Ints | None = None, threads: Threads | None = None) -> Measurements:
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
