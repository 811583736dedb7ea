"""Drivers give way to whom gpsec holds still for ten seconds, no longer, where there is room to pass.

SUMO's vehicles wait before a junction for whoever is on a lane in it that crosses theirs, for as long as that takes. A
wreck just behind its stop line would block the whole junction, and those who wait for those who wait.
"""

from collections.abc import Mapping

import libsumo

from gpsec.traffic.waits import WAITING_GAP_M
from gpsec.traffic.ways import StandingBody, body_of, is_in_the_way, way_of

PATIENCE_S = 10.0
# Who is on the way of somebody so near is not passed; who is farther off is in nobody's way.
_REACH_M = 40.0
_IGNORED = "junctionModel.ignoreIDs"


class Blockers:
    """Who is held still in a simulation, and who passes them."""

    def __init__(self) -> None:
        self._held: Mapping[str, tuple[float, float]] = {}
        self._bodies: dict[str, StandingBody] = {}  # of those who have stood for long
        self._passed: dict[str, str] = {}  # by whom, as SUMO was told

    def read(self, held_m: Mapping[str, tuple[float, float]]) -> None:
        """Take in the fronts of all who brake by order, and tell SUMO who passes them."""
        vehicle = libsumo.vehicle
        present = set(vehicle.getIDList()) if held_m or self._passed else set()
        self._held = {name: front_m for name, front_m in held_m.items() if name in present}
        self._bodies = {
            name: body_of(name, front_m)
            for name, front_m in self._held.items()
            if vehicle.getWaitingTime(name) >= PATIENCE_S
        }
        passed = {name: whom for name in present - self._held.keys() if (whom := " ".join(self._passed_by(name)))}
        for name in sorted(present & (passed.keys() | self._passed.keys())):
            if passed.get(name, "") != self._passed.get(name, ""):
                vehicle.setParameter(name, _IGNORED, passed.get(name, ""))
        self._passed = passed

    def _passed_by(self, name: str) -> list[str]:
        """Return who stands near, but out of the way of a vehicle."""
        vehicle = libsumo.vehicle
        place = complex(*vehicle.getPosition(name))
        near = [other for other, body in self._bodies.items() if abs(body.axis[0] - place) < _REACH_M]
        if not near:
            return near
        way, half_width_m = way_of(name, _REACH_M), 0.5 * vehicle.getWidth(name)
        return [other for other in near if not is_in_the_way(self._bodies[other], way, half_width_m)]

    def holds(self, name: str) -> bool:
        """Return whether a vehicle brakes by order, or somebody who is held still stands close before it."""
        if name in self._held or not self._bodies:
            return name in self._held
        way, half_width_m = way_of(name, WAITING_GAP_M), 0.5 * libsumo.vehicle.getWidth(name)
        return any(is_in_the_way(body, way, half_width_m) for body in self._bodies.values())
