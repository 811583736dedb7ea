"""Drivers give way to whom gpsec holds still for ten seconds, no longer, where there is room to pass.

SUMO's vehicles wait before a junction for whoever is on a lane in it that crosses theirs, for as long as that takes. A
wreck just behind its stop line would block the whole junction, and those who wait for those who wait.
"""

from collections.abc import Mapping, Set

import libsumo
import numpy as np

from gpsec.traffic.waits import WAITING_GAP_M
from gpsec.traffic.ways import StandingBody, body_of, is_in_the_way, way_of

PATIENCE_S = 10.0
# Who has its front so near may be on the way of somebody, with all of its length; who is farther off is not.
_REACH_M = 40.0
_IGNORED = "junctionModel.ignoreIDs"


class Blockers:
    """Who is held still in a simulation, and who passes them."""

    def __init__(self) -> None:
        self._held: Mapping[str, tuple[float, float]] = {}
        self._bodies: dict[str, StandingBody] = {}  # of those who have stood for long
        self._fronts = np.zeros(0, np.complex128)  # of these
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
        self._fronts = np.array([body.axis[0] for body in self._bodies.values()], np.complex128)
        passed = self._passed_by(present - self._held.keys())
        for name in sorted(present & (passed.keys() | self._passed.keys())):
            if passed.get(name, "") != self._passed.get(name, ""):
                vehicle.setParameter(name, _IGNORED, passed.get(name, ""))
        self._passed = passed

    def _passed_by(self, names: Set[str]) -> dict[str, str]:
        """Return by vehicle who stands near, but out of its way; of those of `names` that have somebody to pass."""
        if not self._bodies:
            return {}
        vehicle, passed = libsumo.vehicle, {}
        for name, near in self._near(list(names)).items():
            way, half_width_m = way_of(name, _REACH_M), 0.5 * vehicle.getWidth(name)
            if whom := " ".join(other for other in near if not is_in_the_way(self._bodies[other], way, half_width_m)):
                passed[name] = whom
        return passed

    def _near(self, names: list[str]) -> dict[str, list[str]]:
        """Return by vehicle who stands near, of those of `names` that have somebody near."""
        places = np.array([complex(*libsumo.vehicle.getPosition(name)) for name in names], np.complex128)
        bodies = list(self._bodies)
        found: dict[str, list[str]] = {}
        for at, number in np.argwhere(np.abs(places[:, None] - self._fronts) < _REACH_M).tolist():
            found.setdefault(names[at], []).append(bodies[number])
        return found

    def holds(self, name: str) -> bool:
        """Return whether a vehicle brakes by order, or somebody who is held still stands close before it."""
        if name in self._held:
            return True
        if not self._bodies:
            return False
        near = self._near([name]).get(name, [])
        if not near:
            return False
        way, half_width_m = way_of(name, WAITING_GAP_M), 0.5 * libsumo.vehicle.getWidth(name)
        return any(is_in_the_way(self._bodies[other], way, half_width_m) for other in near)
