"""Vehicles whose lanes come from rendered pictures, in the place of what their profile says of the camera."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import floor
from typing import Any

import numpy as np

from gpsec.core import noise
from gpsec.core.arrays import Floats
from gpsec.core.errors import shown
from gpsec.hdmap.map import HDMap
from gpsec.imaging.pictures.eye import LaneEye, Optics
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.scene import SeenBodies, moment_of
from gpsec.imaging.pictures.weather import WEATHERS
from gpsec.scenario import Scenario
from gpsec.sensors.sense import Sensors
from gpsec.sensors.sense_kernels import CONSTANT
from gpsec.sensors.table import TICKS, TRUST
from gpsec.traffic.source import Departure, Frame
from gpsec.types.vehicles import Measurements, Vehicles

# A channel of `gpsec.core.noise` of its own; nothing that is compiled draws from it.
_CHANNEL = 52


@dataclass(frozen=True)
class PixelCameras:
    """Whose lanes come from pictures, and how they are made; what changes is in `Eyes`.

    Attributes:
        seed: of the run.
        share: of the vehicles, drawn by their keys.
        names: of vehicles that always do, SUMO's.
        optics: of all cameras.
        camera: (P, …) what the profiles say of rate and trust limit, a row of `ProfileTable.camera` each.
        step_s: length of a step.
    """

    seed: int
    share: float
    names: frozenset[str]
    optics: Optics
    camera: Floats
    step_s: float

    def sees(self, departure: Departure) -> bool:
        """Return whether a vehicle's lanes come from pictures; one that goes on as id#2 is what it was as id."""
        name = departure.first_id
        key = noise.vehicle_key(self.seed, name)
        return name in self.names or noise.plain_uniform(key, _CHANNEL, 0) < self.share

    def start(self) -> "Eyes":
        """Return the eyes of a run that begins."""
        return Eyes(self)

    def is_due(self, row: int, step: int, vehicles: Vehicles) -> bool:
        """Return whether the camera of a vehicle row takes a picture in this step, at the rate of its profile."""
        per_step = float(self.camera[vehicles.profile[row], TICKS])
        if per_step >= 1.0:
            return True
        phase = noise.plain_uniform(int(vehicles.key[row]), noise.CAMERA_CLOCK, CONSTANT)
        return floor(phase + per_step * step) > floor(phase + per_step * (step - 1))


class Eyes:
    """The vehicles on the road whose lanes come from pictures."""

    def __init__(self, cameras: PixelCameras) -> None:
        self._cameras = cameras
        self._eyes: dict[int, LaneEye] = {}
        self._names: dict[int, str] = {}
        self._counts: dict[str, tuple[int, int]] = {}
        self._met: set[str] = set()

    def enter(self, departures: Sequence[Departure], vehicles: Vehicles) -> None:
        """Give eyes to those of the vehicles that depart that are to have some."""
        for departure in departures:
            if self._cameras.sees(departure):
                row = departure.row
                self._eyes[row] = self._cameras.optics.eye(float(vehicles.axle_m[row]), int(vehicles.key[row]))
                self._names[row] = departure.vehicle_id
                self._met.add(departure.first_id)

    def leave(self, rows: Iterable[int]) -> None:
        """Forget vehicles that leave, but for what they saw."""
        for row in rows:
            if row in self._eyes:
                self._note(row)
                del self._eyes[row], self._names[row]

    def look(self, frame: Frame, vehicles: Vehicles) -> None:
        """Take the pictures of a step, once the bodies are placed: where the lane is marked, and no other way."""
        rows, step, cameras = frame.rows, frame.step, self._cameras
        if not self._eyes:
            return
        bodies = SeenBodies(
            vehicles.rear_m[rows],
            vehicles.yaw_rad[rows],
            vehicles.axle_m[rows],
            vehicles.length_m[rows],
            vehicles.width_m[rows],
            vehicles.key[rows],
        )
        for row, eye in self._eyes.items():
            if not vehicles.marked[row]:
                eye.rest()
            elif cameras.is_due(row, step, vehicles):
                width_m = float(cameras.optics.hd_map.sides.width_m[vehicles.camera_lane[row]])
                eye.look(moment_of(step, bodies, int(np.searchsorted(rows, row))), width_m)

    def show(self, vehicles: Vehicles, out: Measurements) -> None:
        """Put what was seen into the measurements of the step, in the place of what the profile's camera gave."""
        step_s, trust_m = self._cameras.step_s, self._cameras.camera[:, TRUST]
        for row, eye in self._eyes.items():
            lane = eye.say(float(out.speed_mps[row]) * step_s, float(out.yaw_rate_rps[row]) * step_s)
            out.camera_valid[row] = lane.valid and lane.sigma_m <= trust_m[vehicles.profile[row]]
            out.lane_poly[row] = eye.said.poly
            out.camera_sigma_m[row] = eye.said.sigma_m

    def stated(self) -> dict[str, Any]:
        """Return who saw pictures, and how many of them showed a lane, for the manifest."""
        for row in self._eyes:
            self._note(row)
        who = {name: {"pictures": taken, "lanes": lanes} for name, (taken, lanes) in sorted(self._counts.items())}
        return {"opencv": str(opencv().__version__), "vehicles": who}

    def absent(self) -> list[str]:
        """Return the named vehicles that never departed."""
        return sorted(self._cameras.names - self._met)

    def _note(self, row: int) -> None:
        eye = self._eyes[row]
        self._counts[self._names[row]] = (eye.pictures, eye.lanes)


def pixel_cameras(scenario: Scenario, hd_map: HDMap, sensors: Sensors) -> PixelCameras:
    """Return the cameras of a scenario whose `fleet.camera.source` is ``image``.

    Raises:
        GpsecError: OpenCV is not installed.
    """
    opencv()
    of = scenario.fleet.camera
    optics = Optics(hd_map, WEATHERS[of.image_weather], of.image_mounting_deg, of.image_memory_m)
    names = frozenset(of.image_vehicles)
    return PixelCameras(scenario.seed, of.image_share, names, optics, sensors.table.camera, sensors.step_s)


def pixel_note(scenario: Scenario) -> str:
    """Return what the user should know of a run with pictures, in a sentence."""
    of = scenario.fleet.camera
    who = [f"{100.0 * of.image_share:.3g} % of the vehicles"] if of.image_share > 0.0 else []
    who += [shown(", ".join(of.image_vehicles))] if of.image_vehicles else []
    return (
        f"lanes of {' and '.join(who)} come from rendered pictures (weather {of.image_weather}), in which only vehicles"
        " of the fleet are drawn"
    )
