"""A simulation that takes commands between its steps: the traffic of the closed loop."""

from collections.abc import Mapping, Set
from dataclasses import replace
from math import tan
from time import perf_counter

import libsumo
import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import yaw_from_sumo_angle
from gpsec.core.tables import Slots
from gpsec.traffic.actuation import Actuation
from gpsec.traffic.blockers import Blockers
from gpsec.traffic.commands import Carried, CommandKind, Commands, Others
from gpsec.traffic.delays import LOSS_EVERY_S, Delays
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.session import SUMO_ERRORS, SumoSession
from gpsec.traffic.shadows import MOST_HEADING_RAD
from gpsec.traffic.source import Equip, Frame
from gpsec.traffic.sumo_lanes import SumoLanes

# What all vehicles go without: wander within the lane, which draws from one stream for all, so that one that brakes
# would change all others; and sliding across the road while they stand, which no axle can follow.
LANE_CHANGING = {"lcSigma": "0", "lcMaxSpeedLatStanding": "0", "lcMaxSpeedLatFactor": f"{tan(MOST_HEADING_RAD):.4f}"}


class ControlledSession(SumoSession):
    """`SumoSession` that carries out `gpsec.traffic.commands.Commands`; its frames say how, in `Frame.carried`.

    Positions in frames are true: of a vehicle that is steered, that of SUMO and its surplus. All vehicles change lanes
    by `LANE_CHANGING`.
    """

    def __init__(
        self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip, delay_ms: float | None = None
    ) -> None:
        """Start the simulation; see `SumoSession`."""
        super().__init__(options, lane_index, equip, delay_ms)
        self._actuation = Actuation(SumoLanes(lane_index, options.net_file), self.step_s)
        self._bystanders = _Bystanders()
        self._lane: Ints = np.full(1, -1, np.int32)
        self._removed = 0
        self._teleports = 0
        self._spent_s = 0.0
        self._blockers = Blockers()
        self._delays = Delays(self.step_s)
        self._look_every = max(1, round(LOSS_EVERY_S / self.step_s))

    def command(self, commands: Commands) -> None:
        """Take what is to be done before the next step.

        Raises:
            GpsecError: SUMO refuses it, in its words.
        """
        began = perf_counter()
        try:
            self._bystanders.braking.clear()
            if self._actuation.take(commands, self._lane):
                self._take_others(commands)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None
        self._spent_s += perf_counter() - began

    def _take_others(self, commands: Commands) -> None:
        """Let others brake, and take out who is to be taken out."""
        for at in np.flatnonzero(commands.others & (commands.order == CommandKind.BRAKE)).tolist():
            self._bystanders.brake(int(commands.rows[at]), float(commands.brake_mps2[at]), self.step_s)
        for at in np.flatnonzero(commands.order == CommandKind.REMOVE).tolist():
            names = self._bystanders if commands.others[at] else self._actuation
            name = names.name_of(int(commands.rows[at]))
            if name is not None:
                names.let_go(int(commands.rows[at]))
                libsumo.vehicle.remove(name)
                self._removed += 1

    def _next_frame(self) -> Frame:
        began = perf_counter()
        try:
            self._actuation.place(self._lane)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None
        self._spent_s += perf_counter() - began
        frame = super()._next_frame()
        try:
            return self._carried_out(frame)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None

    def _carried_out(self, frame: Frame) -> Frame:
        """Return the frame with true positions and what became of the commands."""
        for name in libsumo.simulation.getDepartedIDList():
            if name in libsumo.vehicle.getIDList():
                for key, value in LANE_CHANGING.items():
                    libsumo.vehicle.setParameter(name, f"laneChangeModel.{key}", value)
        self._teleports += len(libsumo.simulation.getStartingTeleportIDList())
        self._actuation.leave(frame.left)
        for departure in frame.departures:
            self._actuation.enter(departure.row, departure.sumo_id, departure.width_m)
        if len(frame.rows) and frame.rows[-1] >= len(self._lane):
            self._lane = np.concatenate([self._lane, np.full(2 * int(frame.rows[-1]), -1, np.int32)])
        self._lane[frame.rows] = frame.lane
        began = perf_counter()
        rows = self._actuation.rows
        surplus_m, apart_m = self._actuation.settle(self._lane)
        front_m = frame.front_m.copy()
        front_m[np.searchsorted(frame.rows, rows)] += apart_m
        self._spent_s += perf_counter() - began
        others = self._bystanders.read(self._roster.equipped)
        path = self._actuation.now.path[rows]
        if frame.step % self._look_every == 0:
            self._blockers.read(self._held_m(frame, front_m))
        self._delays.read(frame, self._actuation, self._blockers.holds)
        sums = self._removed, self._teleports, self._delays.lost_s, self._spent_s, self._delays.stuck
        return replace(frame, front_m=front_m, carried=Carried(rows, path, surplus_m, others, *sums))

    def _held_m(self, frame: Frame, front_m: Floats) -> dict[str, tuple[float, float]]:
        """Return the true fronts of all who brake by order."""
        braking = np.flatnonzero(self._actuation.now.brake_mps2[frame.rows] > 0.0)
        names = [self._actuation.name_of(row) or "" for row in frame.rows[braking].tolist()]
        fleet = dict(zip(names, map(tuple, front_m[braking].tolist()), strict=True))
        others = self._bystanders.braking & set(libsumo.vehicle.getIDList())
        return fleet | {name: libsumo.vehicle.getPosition(name) for name in others}


class _Bystanders:
    """The vehicles that are not part of the fleet, by numbers that they keep."""

    def __init__(self) -> None:
        self.braking: set[str] = set()  # in the last step
        self._number_of: dict[str, int] = {}
        self._slots = Slots()

    def name_of(self, number: int) -> str | None:
        """Return SUMO's id of a number, None where there is no such vehicle any more."""
        return next((name for name, own in self._number_of.items() if own == number), None)

    def let_go(self, number: int) -> None:
        """Command one no more."""
        self.braking.discard(self.name_of(number) or "")

    def brake(self, number: int, brake_mps2: float, step_s: float) -> None:
        """Let one brake in the next step."""
        if (name := self.name_of(number)) is not None:
            libsumo.vehicle.setAcceleration(name, -brake_mps2, step_s)
            self.braking.add(name)

    def read(self, equipped: Set[str]) -> Others:
        """Return who is on the road beside the fleet."""
        vehicle = libsumo.vehicle
        if not self._number_of and vehicle.getIDCount() == len(equipped):
            return Others.nobody()
        present = [name for name in vehicle.getIDList() if name not in equipped and vehicle.getRoadID(name)]
        for gone in self._number_of.keys() - set(present):
            self._slots.give_back(self._number_of.pop(gone))
        entered = [name for name in present if name not in self._number_of]
        for name in entered:
            self._number_of[name] = self._slots.take()
        return Others(
            number=np.array([self._number_of[name] for name in present], np.int32),
            entered=np.array([self._number_of[name] for name in entered], np.int32),
            front_m=np.array([vehicle.getPosition(name) for name in present], np.float64).reshape(-1, 2),
            yaw_rad=np.array([yaw_from_sumo_angle(vehicle.getAngle(name)) for name in present], np.float64),
            speed_mps=np.array([vehicle.getSpeed(name) for name in present], np.float64),
            length_m=np.array([vehicle.getLength(name) for name in present], np.float64),
            width_m=np.array([vehicle.getWidth(name) for name in present], np.float64),
            sumo_id=tuple(present),
        )
