"""A run that is shown in sumo-gui: one plan and one defence, vehicles coloured by what becomes of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.progress import Report
from gpsec.outcomes.state import OUT_OF_LANE, OutcomeState
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.remote import RemoteSession
from gpsec.traffic.source import Equip
from gpsec.traffic.sumo_gui import Colour, Look, Outline
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity, Vehicles

CLEAN, UNSEEN, SEEN, FALSE_ALARM, STRAYED = range(5)
# Okabe and Ito's palette, which colour-blind people tell apart: green, orange, sky blue, yellow, vermilion.
COLOURS: tuple[Colour, ...] = (
    (0, 158, 115, 255),
    (230, 159, 0, 255),
    (86, 180, 233, 255),
    (240, 228, 66, 255),
    (213, 94, 0, 255),
)
# Theirs too, reddish purple.
GHOST: Colour = (204, 121, 167, 170)
DELAY_MS = 50.0
# Vehicles that are nearer to where SUMO draws them are not drawn again.
_ELSEWHERE_M = 0.05


@dataclass(frozen=True)
class LiveRun:
    """What `gpsec.running.workers.run_scenarios` calls for a run that is shown.

    Attributes:
        plan: name of the attack plan that is shown, None for the first one.
        defence: name of the defence that is shown, None for the last one with a response.
        delay_ms: time that a step takes at least, from the first attack on; what comes before it is passed over.
    """

    plan: str | None = None
    defence: str | None = None
    delay_ms: float = DELAY_MS

    def __call__(self, scenario: Scenario, folder: Path, report: Report) -> None:
        """Run the scenario; see `run_scenario`."""
        closed = scenario.closed_loop.world is not None
        live = Live(self.plan, self.defence, self.delay_ms, controlled=closed)
        run_scenario(scenario, folder, report, live.start, onlooker=live, takes_commands=closed)


class Live:
    """Tells the window after each step what is to be seen; a `gpsec.pipeline.interfaces.Onlooker`."""

    def __init__(self, plan: str | None, defence: str | None, delay_ms: float, *, controlled: bool = False) -> None:
        self._asked = plan, defence
        self._controlled = controlled
        self._delay_ms = delay_ms
        self._shown: dict[int, tuple[str, int]] = {}  # vehicle row -> id and state
        self._followed = -1  # vehicle row

    def start(self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> RemoteSession:
        """Start the traffic with a window."""
        self._session = RemoteSession(options, lane_index, equip, delay_ms=self._delay_ms, controlled=self._controlled)
        return self._session

    def begin(self, study: Study) -> None:
        """Choose plan and defence.

        Raises:
            GpsecError: there is none of that name, or no plan at all.
        """
        plan, defence = self._asked
        self._plan = choose_plan(study, plan)
        self._defence = choose_defence(study, defence)
        self._detector = int(study.detector_of[self._defence])

    def see(self, view: StepView, outcomes: OutcomeState, fleet: Mapping[int, Identity]) -> None:
        """Hand over the colours that change, and the ghost of the vehicle that is followed."""
        tracks = chosen_tracks(view.rows, view.tracks, self._plan)
        states = track_states(tracks, view.tracks, outcomes, self._defence, self._detector)
        rows = view.tracks.vehicle[tracks].tolist()
        now = {row: (fleet[row].vehicle_id, state) for row, state in zip(rows, states.tolist(), strict=True)}
        changed = [row for row, who in now.items() if self._shown.get(row) != who]
        at = self._follow(rows, view.tracks.attacked[tracks].tolist(), now)
        self._shown = now
        ghost: Outline = ()
        if at >= 0:
            rear_m = view.answers.estimate_m[tracks[at], self._defence]
            ghost = body_outline(rear_m, view.vehicles, rows[at], view.step_s)
        self._session.look = Look(
            [(fleet[row].sumo_id, COLOURS[now[row][1]]) for row in changed],
            ghost,
            GHOST,
            fleet[self._followed].sumo_id if at >= 0 else "",
            list(self._bodies(view, now, fleet)),
        )

    def _bodies(
        self, view: StepView, now: Mapping[int, tuple[str, int]], fleet: Mapping[int, Identity]
    ) -> Iterator[tuple[str, Outline, Colour]]:
        """Yield who is elsewhere than SUMO has them, in closed loop: where they truly are."""
        carried = self._session.carried
        if carried is None:
            return
        for row in carried.rows[np.abs(carried.surplus_m) > _ELSEWHERE_M].tolist():
            if row in now:
                corners = body_outline(view.vehicles.rear_m[row], view.vehicles, row, view.step_s)
                yield fleet[row].sumo_id, corners, COLOURS[now[row][1]]

    def _follow(self, rows: list[int], attacked: list[bool], now: Mapping[int, tuple[str, int]]) -> int:
        """Return where in `rows` the vehicle is that the view follows: one under attack, until it is out of it."""
        former, then = self._followed, self._shown.get(self._followed)
        same = then is not None and former in now and now[former][0] == then[0]
        if not (same and attacked[rows.index(former)]):
            self._followed = next((row for row, hit in zip(rows, attacked, strict=True) if hit), -1)
        return rows.index(self._followed) if self._followed >= 0 else -1


def choose_plan(study: Study, asked: str | None) -> int:
    """Return the index of the plan to show.

    Raises:
        GpsecError: there is none of that name, or no plan at all.
    """
    plans = study.plans[1:]
    if not plans:
        raise GpsecError("--gui: expected an attack plan to show, found none in the scenario")
    if asked is not None and asked not in plans:
        raise GpsecError(f"--gui-plan: unknown plan '{shown(asked)}'; {nearest(asked, plans)}")
    return 1 if asked is None else study.plans.index(asked)


def choose_defence(study: Study, asked: str | None) -> int:
    """Return the index of the defence to show.

    Raises:
        GpsecError: there is none of that name.
    """
    names = study.defence_names
    if asked is not None and asked not in names:
        raise GpsecError(f"--gui-defence: unknown defence '{shown(asked)}'; {nearest(asked, names)}")
    if asked is not None:
        return names.index(asked)
    return max((at for at, (_, response) in enumerate(study.defences) if response != "none"), default=0)


def chosen_tracks(rows: Ints, tracks: Tracks, plan: int) -> Ints:
    """Return one track row for each vehicle: that under `plan` where its attack has begun, otherwise the benign one."""
    track_of = np.full(int(tracks.vehicle[rows].max(initial=-1)) + 1, -1, np.int32)
    for number in (0, plan):
        under = rows[tracks.plan[rows] == number]
        track_of[tracks.vehicle[under]] = under
    return track_of[track_of >= 0]


def track_states(rows: Ints, tracks: Tracks, outcomes: OutcomeState, defence: int, detector: int) -> Ints:
    """Return the state of each track of `rows`.

    Detected is an attack from the first alarm within it, and a lane is left for good, as the tables count it. An alarm
    is false while nobody attacks.
    """
    states = np.full(len(rows), CLEAN, np.int32)
    attacked = tracks.attacked[rows]
    seen = outcomes.detection_step[rows, detector] >= 0
    states[attacked] = np.where(seen, SEEN, UNSEEN)[attacked]
    states[outcomes.in_alarm[rows, detector] & ~attacked] = FALSE_ALARM
    states[outcomes.first_step[rows, defence, OUT_OF_LANE] >= 0] = STRAYED
    return states


def body_outline(rear_m: Floats, vehicles: Vehicles, row: int, lead_s: float) -> Outline:
    """Return the corners of a vehicle's body if its rear axle were at `rear_m` (2,): five of them, with a nose.

    It is moved on by `lead_s` of driving: sumo-gui draws it beside where the vehicle is a step later.
    """
    lead_m = lead_s * float(vehicles.speed_mps[row])
    axle_m, length_m = float(vehicles.axle_m[row]), float(vehicles.length_m[row])
    half_m, yaw = 0.5 * float(vehicles.width_m[row]), float(vehicles.yaw_rad[row])
    front_m, back_m = lead_m + axle_m, lead_m + axle_m - length_m
    corners = (
        (back_m, half_m),
        (back_m, -half_m),
        (front_m - half_m, -half_m),
        (front_m, 0.0),
        (front_m - half_m, half_m),
    )
    c, s = float(np.cos(yaw)), float(np.sin(yaw))
    x_m, y_m = (float(value) for value in rear_m)
    return tuple((x_m + c * along - s * left, y_m + s * along + c * left) for along, left in corners)
