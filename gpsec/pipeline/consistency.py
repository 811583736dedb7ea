"""Runs honest traffic and compares what the filters say of their errors with their errors, while lanes are known.

``python -m gpsec.pipeline.consistency SCENARIO [PROFILE ...]`` prints a table.
"""

import sys
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gpsec.attacks.plans import plan_config
from gpsec.core.arrays import Floats, Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.threads import Threads
from gpsec.localization.consistency import Consistency, along_and_across, consistency, nees, nis
from gpsec.pipeline.batched import BatchedMethod
from gpsec.pipeline.build import drawn_zones, lay_ground, loop_settings, make_detection, make_localization, make_plans
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.mismatch import make_shared_errors
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.remote import RemoteSession
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# An attack that displaces nothing: it only lets `told` isolate.
_ALARM = {"attack": "constant_bias", "name": "alarm", "bias_m": 1e-12, "share": 1.0, "duration_s": [30.0, 30.0]}
# What is called EKF below is what trusts GNSS all the time.
TRUSTING = {"EKF": ("never", "none"), "considering EKF": ("never", "consider_ukf"), "learning EKF": ("never", "ukf5")}
ISOLATED = {name: ("told", name) for name in ("dead_reckoning", "ukf", "consider_ukf", "ukf5")}
EVERY_STEPS = 5


class Ledger:
    """Normalised squares of every filter, with the vehicle that each is of."""

    def __init__(self) -> None:
        self._squares: dict[tuple[str, str], list[Floats]] = defaultdict(list)
        self._vehicle: dict[tuple[str, str], list[Ints]] = defaultdict(list)

    def add(self, name: str, error: Floats, covariance: Floats, yaw_rad: Floats, vehicle: Ints) -> None:
        """Take in (n, 2) errors with (n, 2, 2) covariances in the net's frame."""
        turn = np.empty_like(covariance)
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = c, s, -s, c
        body = np.einsum("nij,njk,nlk->nil", turn, covariance, turn)
        parts = along_and_across(error, yaw_rad)
        self._note(name, "NEES position", nees(error, covariance), vehicle)
        self._note(name, "NEES along", parts[:, 0] ** 2 / body[:, 0, 0], vehicle)
        self._note(name, "NEES across", parts[:, 1] ** 2 / body[:, 1, 1], vehicle)
        self._note(name, "mean along (m)", parts[:, 0], vehicle)
        self._note(name, "mean across (m)", parts[:, 1], vehicle)

    def add_innovations(self, name: str, innovation: Floats, vehicle: Ints) -> None:
        """Take in (n, 2) normalised innovations."""
        self._note(name, "NIS", nis(innovation), vehicle)

    def _note(self, name: str, quantity: str, values: Floats, vehicle: Ints) -> None:
        self._squares[name, quantity].append(values)
        self._vehicle[name, quantity].append(vehicle)

    def sums(self) -> dict[tuple[str, str], Consistency]:
        """Return what was found for each filter and quantity; of a mean error the expectation is 0."""
        freedom = {"NIS": 2, "NEES position": 2, "NEES along": 1, "NEES across": 1}
        return {
            key: consistency(np.concatenate(squares), np.concatenate(self._vehicle[key]), freedom.get(key[1], 0))
            for key, squares in self._squares.items()
        }


class _Watching(BatchedMethod):
    """The batched engine, with an eye on its filters."""

    ledger: Ledger
    names: dict[str, int]

    def step(
        self,
        number: int,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
        watch: Stopwatch,
    ) -> None:
        """Take one step, and note errors."""
        super().step(number, rows, tracks, vehicles, seen, threads, watch)
        if (number + 1) % EVERY_STEPS:
            return
        for name, d in self.names.items():
            filters, branch = self.filters.of(d)
            chosen = rows[tracks.settled[rows] & (tracks.plan[rows] == (0 if name in TRUSTING else 1))]
            if name in ISOLATED:
                chosen = chosen[self.answers.isolated[chosen, d] & tracks.attacked[chosen]]
                # Who holds another lane for its own is lost, and no filter's covariance says so.
                chosen = chosen[tracks.lane[chosen] == vehicles.camera_lane[tracks.vehicle[chosen]]]
            at = branch[chosen]
            vehicle = tracks.vehicle[chosen]
            # A vehicle is known by its key: its row is another's after it has left.
            who = vehicles.key[vehicle].astype(np.int64)
            error = filters.mean[at, :2] - vehicles.rear_m[vehicle]
            self.ledger.add(name, error, filters.covariance[at, :2, :2], vehicles.yaw_rad[vehicle], who)
            fresh = filters.innovation_valid[at]
            if name in TRUSTING:
                self.ledger.add_innovations(name, filters.innovation[at[fresh]], who[fresh])


def measure_consistency(scenario: Scenario, profile: str, duration_s: float) -> dict[tuple[str, str], Consistency]:
    """Return, for each filter and quantity, what honest traffic of one sensor profile gives."""
    defences = [*TRUSTING.values(), *ISOLATED.values()]
    honest = scenario.model_copy(
        update={
            "fleet": scenario.fleet.model_copy(update={"profile": {profile: 1.0}}),
            "detection": scenario.detection.model_copy(update={"detectors": ()}),
            "defences": tuple(Defence(detector=detector, response=response) for detector, response in defences),
            "plans": (plan_config(_ALARM, "consistency"),),
        }
    )
    ground = lay_ground(honest)
    detection = make_detection(honest, ground)
    localization = make_localization(honest, ground.world, detection.names)
    method = _Watching(ground.world, ground.association, detection, localization)
    method.ledger, method.names = Ledger(), {name: d for d, name in enumerate([*TRUSTING, *ISOLATED])}
    with RemoteSession(ground.options, ground.hd_map.lane_index, ground.choice.equipped) as session:
        zones = drawn_zones(session)
        around = make_shared_errors(honest, ground.sensors, ground.hd_map, zones)
        settings = loop_settings(honest, ground, session.step_s, around)
        loop = Loop(settings, make_plans(honest, ground, ground.options, zones)[:1], method)
        for frame in session.frames(duration_s):
            loop.step(frame)
        session.close()
    return method.ledger.sums()


def main(arguments: Sequence[str]) -> None:
    """Print a table for a scenario and some profiles, or all."""
    scenario = load_scenario(Path(arguments[0]))
    print(
        "profile     filter          quantity          mean   95 % interval     expected  chi-square bounds  vehicles"
    )
    for profile in arguments[1:] or list(PROFILES):
        for (name, quantity), found in measure_consistency(scenario, profile, scenario.duration_s or 180.0).items():
            bounds = f"{found.bound_lo:.2f} … {found.bound_hi:.2f}" if found.freedom else ""
            print(
                f"{profile:<12}{name:<16}{quantity:<18}{found.mean:6.3f}  {found.lo:6.3f} … {found.hi:6.3f}"
                f"  {found.freedom:8d}  {bounds:>17}  {found.vehicles:8d}"
            )


if __name__ == "__main__":
    main(sys.argv[1:])
