"""A log's drive as traffic, as truth and as measurements of a run."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import cos, sin

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.replay.chain import lane_id
from gpsec.replay.grid import LOG_STEP_S, SteppedDrive
from gpsec.sensors.sense import Sensors
from gpsec.sensors.state import SensorState
from gpsec.traffic.body import axle_distance
from gpsec.traffic.offline import OfflineTraffic
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Departure, Equip, Frame, step_count
from gpsec.types.vehicles import Measurements, Vehicles

# A log does not say what body it is of: a passenger car.
LENGTH_M, WIDTH_M = 4.6, 1.8
AXLE_M = axle_distance(LENGTH_M)


@dataclass(frozen=True)
class Driven:
    """A drive, and how it lies on its chain.

    Attributes:
        drive: of the log.
        edge: (S,) edge of the chain that the front is on.
        copies: how often the drive takes part, each time attacked at another time.
        name: of the vehicle.
    """

    drive: SteppedDrive
    edge: Ints
    copies: int
    name: str

    def vehicle_id(self, copy: int) -> str:
        """Return the name of one of the copies."""
        return self.name if self.copies == 1 else f"{self.name}-{copy + 1}"


class LoggedTraffic(OfflineTraffic):
    """The copies of a drive, which enter in the first step and are there to the last."""

    def __init__(self, driven: Driven, options: SumoOptions, lane_index: dict[str, int], equip: Equip) -> None:
        super().__init__(options)
        self.step_s = LOG_STEP_S
        self._driven = driven
        lanes = np.array([lane_index[lane_id(number)] for number in range(int(driven.edge.max()) + 1)], np.int32)
        self._lane = lanes[driven.edge]
        entered = [replace(self._departure(copy), row=-1) for copy in range(driven.copies)]
        kept = [departure for departure in entered if equip(departure)]
        self._departures = [replace(departure, row=row) for row, departure in enumerate(kept)]

    def _departure(self, copy: int) -> Departure:
        drive, name = self._driven.drive, self._driven.vehicle_id(copy)
        return Departure(
            row=-1,
            vehicle_id=name,
            vehicle_type="logged",
            vehicle_class="passenger",
            length_m=LENGTH_M,
            width_m=WIDTH_M,
            yaw_rad=float(drive.yaw_rad[0]),
            speed_mps=float(drive.speed_mps[0]),
            equipped_share=None,
            sensors=None,
            sumo_id=name,
        )

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps of the drive, all or those of `duration_s`."""
        drive, rows = self._driven.drive, np.arange(len(self._departures), dtype=np.int32)
        count = len(drive) if duration_s is None else min(len(drive), step_count(duration_s, LOG_STEP_S))
        for step in range(count):
            yaw, rear_m = drive.yaw_rad[step], drive.rear_m[step]
            front_m = rear_m + AXLE_M * np.array([cos(yaw), sin(yaw)])
            yield Frame(
                step=step,
                time_s=round((step + 1) * LOG_STEP_S, 6),
                left=[],
                departures=self._departures if step == 0 else [],
                rows=rows,
                front_m=np.tile(front_m, (len(rows), 1)),
                lane=np.full(len(rows), self._lane[step], np.int32),
                on_road=len(rows),
            )


@dataclass(frozen=True)
class LoggedBodies:
    """Moves the bodies as the log's pose says; see `gpsec.pipeline.loop_settings.Move`."""

    drive: SteppedDrive

    def __call__(self, frame: Frame, step_s: float, vehicles: Vehicles) -> None:
        """Place the vehicles of a step."""
        rows, step, drive = frame.rows, frame.step, self.drive
        vehicles.front_m[rows] = frame.front_m
        vehicles.rear_m[rows] = drive.rear_m[step]
        vehicles.yaw_rad[rows] = drive.yaw_rad[step]
        vehicles.speed_mps[rows] = drive.speed_mps[step]
        vehicles.yaw_rate_rps[rows] = drive.yaw_rate_rps[step]
        vehicles.fresh[rows] = False


@dataclass(frozen=True)
class LoggedSensors(Sensors):
    """Sensors whose measurements are the log's, and of the profile only where the log has none.

    Attributes:
        drive: what the log's sensors gave.
    """

    drive: SteppedDrive = field(kw_only=True)

    @cached_property
    def common_shares(self) -> Floats:
        """(P,) nothing is in common where fixes are the log's: what receivers share is in them."""
        own = super().common_shares
        return np.zeros_like(own) if len(self.drive.fix_m) else own

    def sense(
        self,
        state: Table[SensorState],
        vehicles: Vehicles,
        measurements: Measurements,
        rows: Ints,
        step: int,
        threads: Threads,
    ) -> None:
        """Fill the measurements of this step."""
        super().sense(state, vehicles, measurements, rows, step, threads)
        drive, out = self.drive, measurements
        if len(drive.odometer_mps):
            out.speed_mps[rows] = drive.odometer_mps[step]
        if len(drive.gyro_rps):
            out.yaw_rate_rps[rows] = drive.gyro_rps[step]
        if len(drive.heading_rad):
            out.heading_rad[rows] = drive.heading_rad[step]
        if len(drive.fix_m):
            out.fix_valid[rows] = drive.fix_there[step]
            out.fix_m[rows] = drive.fix_m[step]
        if len(drive.lane):
            self._show_lane(out, rows, step)

    def _show_lane(self, out: Measurements, rows: Ints, step: int) -> None:
        c0_to_c3, sigma_m = self.drive.lane[step, :4], self.drive.lane[step, 4]
        # Where the camera states nothing, its profile does.
        stated = sigma_m if sigma_m > 0.0 else self.camera_sigma_m
        out.camera_valid[rows] = self.drive.lane_there[step]
        out.lane_poly[rows] = c0_to_c3
        out.camera_sigma_m[rows] = stated

    @property
    def camera_sigma_m(self) -> float:
        """What the camera of the first profile states on a straight road."""
        camera = self.profiles[0].camera
        return float(np.sqrt(camera.white_m**2 + camera.bias_m**2 + camera.mount_m**2))
