"""Synthetic sensors of a whole fleet: truth in, measurements out."""

from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.errors import GpsecError
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.sensors.faults import NO_FAULTS
from gpsec.sensors.lane_faults import fault_lanes
from gpsec.sensors.mismatch import AS_STATED, Mismatch
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.sense_kernels import enter_rows, sense_rows
from gpsec.sensors.smooth import RATE
from gpsec.sensors.state import SensorState
from gpsec.sensors.table import LATENCY, ProfileTable, pack
from gpsec.sensors.tapes import NO_TAPES, Tapes
from gpsec.sensors.wander import enter_wander, wander_fixes
from gpsec.types.vehicles import Measurements, Vehicles


@dataclass(frozen=True)
class Sensors:
    """The sensors of a run; what changes is in a `SensorState`.

    Attributes:
        profiles: those of the run; `Vehicles.profile` is an index into them.
        step_s: length of a step.
        mismatch: by what they differ from their data sheets.
        tapes: in the place of noise, bias and outages.

    Raises:
        GpsecError: there is no profile, or one appears twice.
    """

    profiles: tuple[SensorProfile, ...]
    step_s: float
    mismatch: Mismatch = AS_STATED
    tapes: Tapes = NO_TAPES

    def __post_init__(self) -> None:
        if not self.step_s > 0.0:
            raise GpsecError(f"sensors: expected a positive step length, found {self.step_s:g} s")
        _ = self.table

    @cached_property
    def table(self) -> ProfileTable:
        """What the sensors do, as arrays for kernels."""
        table = self.mismatch.applied(self.stated)
        return self.tapes.applied(table)

    @cached_property
    def stated(self) -> ProfileTable:
        """What the data sheets of the profiles say, as arrays; with a tape, receivers have no common part but it."""
        table = pack(self.profiles, self.step_s)
        return table if self.tapes.gnss is None else table._replace(common=np.zeros(len(self.profiles)))

    @cached_property
    def common_shares(self) -> Floats:
        """(P,) share of the variance of the slow error of fixes that all receivers have in common."""
        return self.mismatch.common_shares(self.stated)

    @cached_property
    def _wanders(self) -> bool:
        return bool((self.table.wander[:, RATE] > 0.0).any())

    @cached_property
    def _has_faults(self) -> bool:
        return bool((self.table.faults != NO_FAULTS).any())

    def new_state(self, capacity: int) -> Table[SensorState]:
        """Return the sensors' own arrays for `capacity` vehicle rows."""
        table = self.table
        carried = max(channel[:, LATENCY].max() for channel in (table.gnss, table.camera, table.heading))
        window = max(channel[:, LATENCY].max() for channel in (table.odometer, table.gyro))
        return Table(SensorState, capacity, slip_steps=ceil(carried) + 1, motion_steps=floor(window) + 2)

    def enter(self, state: Table[SensorState], vehicles: Vehicles, rows: Ints, step: int) -> None:
        """Give `rows` to vehicles that enter: forget all, and draw their biases, constants and lasting outages.

        What is constant for a vehicle depends on its key alone, the rest on its key and the `step` of entry.
        `vehicles.key` and `vehicles.profile` must be set.
        """
        state.reset(rows)
        enter_rows(rows, step, vehicles, self.table, state.now)
        if self._wanders:
            enter_wander(rows, step, vehicles, self.table.wander, state.now)

    def sense(
        self,
        state: Table[SensorState],
        vehicles: Vehicles,
        measurements: Measurements,
        rows: Ints,
        step: int,
        threads: Threads,
    ) -> None:
        """Fill the measurements of (n,) vehicle `rows` for this step, from the truth after it.

        To be called once in every step between `enter` and departure. Draws are counted by `step`, the number
        of the step in the run (from 0). Where a sample is missing, its mask is false and its value the last one.
        """
        threads.run(sense_rows, rows, step, self.step_s, vehicles, self.table, state.now, measurements)
        if self._wanders:
            threads.run(wander_fixes, rows, step, vehicles, self.table.wander, state.now, measurements)
        if self._has_faults:
            threads.run(fault_lanes, rows, step, vehicles, self.table, state.now, measurements)
        self.tapes.play(rows, step, self.step_s, vehicles, self.table, self.mismatch, measurements, threads)
