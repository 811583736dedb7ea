"""The traffic of a scenario, kept moment by moment, so that any vehicle's view can be rendered afterwards."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gpsec.core import noise
from gpsec.core.arrays import Flags, Floats, Ints, Keys, Longs
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.tables import Table
from gpsec.hdmap.locating import locate
from gpsec.hdmap.map import HDMap
from gpsec.imaging.pictures.scene import Moment, SeenBodies, moment_of
from gpsec.pipeline.build import lay_ground
from gpsec.scenario import Scenario
from gpsec.sensors.lane_view import lane_polynomial
from gpsec.traffic.body import advance, axle_distance
from gpsec.traffic.remote import RemoteSession
from gpsec.traffic.source import Departure, Frame
from gpsec.types.camera import NO_MISTAKES
from gpsec.types.vehicles import Vehicles


@dataclass(frozen=True)
class Film:
    """T moments of V vehicles, n rows in all, those of a moment together.

    Attributes:
        hd_map: the roads.
        step_s: between moments.
        time_s: (T,) of each.
        first: (T + 1,) first row of each.
        vehicle: (n,) which it is; `names` says who: (V,).
        axle_m, length_m, width_m, key: (V,) of the vehicles.
        rear_m, yaw_rad, speed_mps, yaw_rate_rps: (n, 2) and (n,) of the bodies.
        truth: (n, 4) C0 … C3 (Eq 1) of the lane that is looked at.
        lane: (n,) that lane.
        marked: (n,) it can be seen: the vehicle is not inside a junction, and not on an oncoming lane.
    """

    hd_map: HDMap
    step_s: float
    time_s: Floats
    first: Longs
    names: tuple[str, ...]
    axle_m: Floats
    length_m: Floats
    width_m: Floats
    key: Keys
    vehicle: Longs
    rear_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    yaw_rate_rps: Floats
    truth: Floats
    lane: Ints
    marked: Flags

    def rows_of(self, name: str) -> Longs:
        """Return the rows of a vehicle, in the order of time.

        Raises:
            GpsecError: it is not on the road in the time that is kept.
        """
        if name not in self.names:
            raise GpsecError(
                f"--vehicle: '{shown(name)}' is not on the road from {self.time_s[0]:g} to {self.time_s[-1]:g} s; "
                f"{nearest(name, self.names)}"
            )
        return np.flatnonzero(self.vehicle == self.names.index(name))

    def moment(self, row: int) -> Moment:
        """Return what the camera of a row's vehicle has around it."""
        at = self.moment_of(row)
        rows = np.arange(self.first[at], self.first[at + 1])
        who = self.vehicle[rows]
        bodies = SeenBodies(
            self.rear_m[rows],
            self.yaw_rad[rows],
            self.axle_m[who],
            self.length_m[who],
            self.width_m[who],
            self.key[who],
        )
        return moment_of(at, bodies, row - int(self.first[at]))

    def moment_of(self, row: int) -> int:
        """Return the number of the moment that a row is of."""
        return int(np.searchsorted(self.first, row, side="right")) - 1


def everybody(departure: Departure) -> bool:
    """Equip every vehicle."""
    return True


def film(scenario: Scenario, from_s: float, to_s: float, tell: Callable[[int, int], None]) -> Film:
    """Run the traffic of a scenario and keep it from one simulated time to another; `tell` hears how far it is.

    Raises:
        GpsecError: the scenario cannot be run, or nobody is on the road then.
    """
    ground = lay_ground(scenario)
    reel = _Reel(ground.hd_map, scenario.seed)
    with RemoteSession(ground.options, ground.hd_map.lane_index, everybody) as session:
        for frame in session.frames(None):
            reel.step(frame, session.step_s, keep=frame.time_s >= from_s - 1e-6)
            if frame.step % 10 == 0:
                tell(round(frame.time_s), round(to_s))
            if frame.time_s >= to_s - 1e-6:
                break
        step_s = session.step_s
    if not reel.rows:
        raise GpsecError(f"{scenario.name}: nobody is on the road from {from_s:g} to {to_s:g} s")
    return reel.film(step_s)


class _Reel:
    """Follows the bodies of a simulation, and keeps them."""

    def __init__(self, hd_map: HDMap, seed: int) -> None:
        self._map, self._seed = hd_map, seed
        self._roads = hd_map.roads(np.zeros(1, np.int32))
        self._table = Table(Vehicles)
        self._number = np.zeros(1, np.int64)  # of the vehicle in each row
        self._people: list[tuple[str, float, float, float]] = []
        self._times: list[float] = []
        self._count: list[int] = []
        self.rows: list[tuple[np.ndarray, ...]] = []

    def step(self, frame: Frame, step_s: float, keep: bool) -> None:
        """Take in one step of the traffic."""
        self._depart(frame)
        rows, vehicles = frame.rows, self._table.now
        vehicles.lane[rows] = frame.lane
        advance(rows, frame.front_m, step_s, vehicles)
        locate(rows, frame.step, step_s, self._roads, NO_MISTAKES, vehicles)
        if not keep or not len(rows):
            return
        v = vehicles
        self._times.append(frame.time_s)
        self._count.append(len(rows))
        truth = np.array(
            [
                lane_polynomial(offset, turn, bend)
                for offset, turn, bend in zip(
                    v.camera_offset_m[rows].tolist(),
                    _wrapped(v.camera_yaw_rad[rows] - v.yaw_rad[rows]).tolist(),
                    v.camera_curvature_per_m[rows].tolist(),
                    strict=True,
                )
            ]
        )
        kept = (v.rear_m, v.yaw_rad, v.speed_mps, v.yaw_rate_rps)
        self.rows.append((self._number[rows], *(of[rows] for of in kept), truth, v.camera_lane[rows], v.marked[rows]))

    def _depart(self, frame: Frame) -> None:
        if not frame.departures:
            return
        new = np.array([departure.row for departure in frame.departures], np.int32)
        if int(new.max()) >= self._table.capacity:
            self._table.grow(2 * int(new.max()) + 2)
        if self._table.capacity > len(self._number):
            self._number = np.concatenate([self._number, np.zeros(self._table.capacity - len(self._number), np.int64)])
        self._table.reset(new)
        vehicles = self._table.now
        for departure in frame.departures:
            row, axle_m = departure.row, axle_distance(departure.length_m)
            vehicles.axle_m[row] = axle_m
            vehicles.yaw_rad[row] = departure.yaw_rad
            vehicles.speed_mps[row] = departure.speed_mps
            self._number[row] = len(self._people)
            self._people.append((departure.vehicle_id, axle_m, departure.length_m, departure.width_m))

    def film(self, step_s: float) -> Film:
        """Return what was kept."""
        columns = [np.concatenate(parts) for parts in zip(*self.rows, strict=True)]
        seen, vehicle = np.unique(columns[0], return_inverse=True)
        people = [self._people[number] for number in seen.tolist()]
        names = tuple(name for name, _, _, _ in people)
        sizes = np.array([sizes for _, *sizes in people])
        return Film(
            self._map,
            step_s,
            np.array(self._times),
            np.concatenate([[0], np.cumsum(self._count)]),
            names,
            sizes[:, 0],
            sizes[:, 1],
            sizes[:, 2],
            np.array([noise.vehicle_key(self._seed, name) for name in names], np.uint64),
            vehicle,
            *columns[1:],
        )


def _wrapped(angle_rad: Floats) -> Floats:
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi
