"""The closed loop: estimates and alarms of a step become commands, and what truly happens is written down."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gpsec.attacks.base import unit_vectors
from gpsec.core.arrays import Flags, Ints
from gpsec.core.geo import Projector
from gpsec.core.noise import INJECTED_ALARM, uniforms
from gpsec.encounters.encounters import EncounterRules, Encounters, Met, People
from gpsec.hdmap.map import HDMap
from gpsec.outcomes.state import OFF_ROAD, OUT_OF_LANE
from gpsec.outcomes.true_outcomes import TrueOutcomes, TrueStep
from gpsec.outcomes.worlds import WorldEnd, WorldKey, write_kept, write_world
from gpsec.pipeline.collisions import KIND_NAMES, Collisions
from gpsec.pipeline.kept import FleetNow, Kept
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.on_the_road import numbers, people_of
from gpsec.pipeline.road_state import RoadState
from gpsec.scenario import Scenario
from gpsec.scenario.worlds import can_steer
from gpsec.steering.base import Follow
from gpsec.steering.registry import DYNAMICS, REACTIONS, build_part
from gpsec.steering.steer import Drivers, Steering, Wishes
from gpsec.traffic.commands import Carried, CommandKind, Commands
from gpsec.traffic.source import Frame
from gpsec.types.answers import Answers
from gpsec.types.vehicles import Vehicles

# Of a wreck, tyres on asphalt; of who is off the road.
WRECK_BRAKE_MPS2, OFF_ROAD_BRAKE_MPS2 = 8.0, 4.0
# So far beyond a line the lane is still seen; cameras keep to it for a while.
_SEEN_M = 0.3
# Who is nearer to their path than this, and does not brake, drives as SUMO would: their touches are no encounters.
ON_PATH_M = 0.3
# A larger surplus is counted: there SUMO's other vehicles do not see a vehicle where it is.
SURPLUS_M = 0.3


@dataclass(frozen=True)
class Acting:
    """The defence that steers: its number, and the column of its detector."""

    defence: int
    detector: int


class ClosedLoop:
    """The vehicles of a world as they are steered, and what becomes of them."""

    def __init__(
        self, scenario: Scenario, hd_map: HDMap, profiles: tuple[str, ...], acting: Acting, step_s: float
    ) -> None:
        section = scenario.closed_loop
        world = section.world
        if world is None:
            raise ValueError("expected a scenario of a world")
        reaction = world.on_alarm or section.on_alarm
        rate_per_h = world.false_alarms_per_h
        self._key = WorldKey(scenario.name, scenario.seed, world.plan, world.defence, reaction, rate_per_h)
        self._injected = rate_per_h * step_s / 3600.0  # probability in a step
        self._acting, self._step_s, self._section = acting, step_s, section
        self._able = np.array([can_steer(name) for name in profiles])
        self._steering = Steering(
            step_s,
            build_part(DYNAMICS, section.dynamics, section.dynamics_parameters),
            build_part(REACTIONS, reaction, section.reaction_parameters),
            everybody=section.steer == "all",
            delay_s=section.delay_s,
        )
        self._encounters = Encounters(EncounterRules(step_s, section.oncoming_reaction_s, section.wreck_s))
        self._happened = TrueOutcomes(step_s, 0.0)
        self._kept = Kept(hd_map, step_s)
        self._state = RoadState(hd_map.sides)
        self._names: dict[int, str] = {}
        self._taken_away: set[int] = set()  # rows of wrecks, until they have left
        self._collisions = Collisions(self._names, self._happened, self._kept)
        self._critical = [0, 0]
        self._surplus = [0, 0]
        self._carried: Carried | None = None

    def leave(self, frame: Frame) -> None:
        """Close the stories of who has left, and begin those of who has departed; before the loop takes the frame."""
        people = {row: self._names.pop(row) for row in frame.left}
        self._happened.close(people, KIND_NAMES)
        self._happened.totals.arrived += len(people.keys() - self._taken_away)
        self._taken_away -= people.keys()
        new = np.array([departure.row for departure in frame.departures], np.int32)
        for departure in frame.departures:
            self._names[departure.row] = departure.vehicle_id
            self._happened.totals.arrived -= departure.first_id != departure.vehicle_id  # it has only gone on
        if frame.left or len(new):
            changed = np.concatenate([np.array(frame.left, np.int32), new])
            self._encounters.forget(numbers(changed, others=False))
            self._kept.enter(numbers(new, others=False))
        if frame.carried is not None and len(frame.carried.others.entered):
            entered = numbers(frame.carried.others.entered, others=True)
            self._encounters.forget(entered)
            self._kept.enter(entered)
        if len(new):
            self._steering.enter(new)
            self._happened.enter(new)
            self._state.enter(new)

    def step(self, frame: Frame, loop: Loop, answers: Answers) -> Commands:
        """Return what is to be done after a step that the loop has taken."""
        carried = frame.carried
        if carried is None:
            raise ValueError("expected traffic that takes commands")
        self._carried = carried
        rows, vehicles, state = frame.rows, loop.vehicles, self._state
        state.note(rows, frame.lane, carried)
        people = self._drivers(frame.step, rows, loop, answers)
        wishes = self._steering.update(frame.step, people)
        steered = self._steering.now
        found = state.reached(rows, vehicles.width_m[rows], steered)
        driven = steered.driven[rows]
        off_path = (np.abs(steered.offset_m[rows]) > ON_PATH_M) | (steered.brake_mps2[rows] > 0.0)
        ours = (driven & off_path) | state.braking[rows]
        party = people_of(rows, vehicles, carried.others, ours, driven & found[:, OUT_OF_LANE])
        met = self._encounters.update(frame.step, party)
        self._note(frame, people, found, wishes, met)
        if self._kept.due(frame.step) or len(met.hits.first):
            self._keep(frame, party, met, self._fleet_now(loop, answers, people))
        count = len(rows)
        state.wrecked[rows], state.braking[rows] = met.wrecked[:count], met.braking[:count]
        return self._commands(rows, found, wishes, met, carried)

    def _drivers(self, step: int, rows: Ints, loop: Loop, answers: Answers) -> Drivers:
        tracks, vehicles = loop.tracks, loop.vehicles
        track = _tracks_of(rows, loop)
        able = self._able[vehicles.profile[rows]]
        off_m = answers.estimate_m[track, self._acting.defence] - vehicles.rear_m[rows]
        alarm = answers.alarm[track, self._acting.detector]
        if self._injected > 0.0:
            alarm = alarm | (uniforms(vehicles.key[rows], INJECTED_ALARM, step) < self._injected)
        along = unit_vectors(vehicles.lane_yaw_rad[rows])
        error_m = along[:, 0] * off_m[:, 1] - along[:, 1] * off_m[:, 0]
        return Drivers(
            rows=rows,
            key=vehicles.key[rows],
            settled=tracks.settled[track] & able,
            attacked=tracks.attacked[track] & able,
            alarm=alarm & able & tracks.settled[track],
            error_m=np.where(vehicles.against[rows], 0.0, error_m),
            edge_m=self._state.edge_m(rows, vehicles.width_m[rows]),
            speed_mps=vehicles.speed_mps[rows],
            wrecked=self._state.wrecked[rows],
        )

    def _fleet_now(self, loop: Loop, answers: Answers, people: Drivers) -> FleetNow:
        rows, steered = people.rows, self._steering.now
        estimate_m = answers.estimate_m[_tracks_of(rows, loop), self._acting.defence]
        return FleetNow(
            lane=self._state.path[rows],
            off_m=estimate_m - loop.vehicles.rear_m[rows],
            displaced_m=np.where(steered.driven[rows], steered.offset_m[rows], 0.0),
            attacked=people.attacked,
            alarm=people.alarm,
            brakes=steered.driven[rows] & (steered.brake_mps2[rows] > 0.0),
        )

    def _keep(self, frame: Frame, party: People, met: Met, fleet: FleetNow) -> None:
        """Write down the hits of a step, and keep what the report shows of it."""
        now = self._kept.moment(frame.time_s, party, fleet, met.wrecked)
        self._collisions.note(frame, met.hits, now, self._steering.now.offset_m)
        if self._kept.due(frame.step):
            self._kept.see(now)

    def _note(self, frame: Frame, people: Drivers, found: Flags, wishes: Wishes, met: Met) -> None:
        rows, steered = frame.rows, self._steering.now
        driven = steered.driven[rows]
        reacts = driven & steered.reacts[rows] & (steered.follow[rows] == Follow.LANE)
        now = TrueStep(
            rows=rows,
            attacked=people.attacked,
            alarm=people.alarm,
            speed_mps=people.speed_mps,
            offset_m=np.where(driven, steered.offset_m[rows], 0.0),
            reached=found,
            stopping=driven & (steered.brake_mps2[rows] > 0.0),
            driver=reacts & (steered.brake_mps2[rows] == 0.0),
            released=wishes.released,
        )
        self._happened.add(frame.step, now)
        self._critical[0] += met.critical_ttc
        self._critical[1] += met.critical_drac
        self._surplus[0] += int((np.abs(frame.carried.surplus_m) > SURPLUS_M).sum()) if frame.carried else 0
        self._surplus[1] += len(wishes.rows)

    def _commands(self, rows: Ints, found: Flags, wishes: Wishes, met: Met, carried: Carried) -> Commands:
        section, count = self._section, len(rows)
        steered = self._steering.now
        brake = np.zeros(count)
        driven = steered.driven[rows]
        brake[driven] = steered.brake_mps2[rows[driven]]
        if section.off_road == "stop":
            brake = np.where(found[:, OFF_ROAD], np.maximum(brake, OFF_ROAD_BRAKE_MPS2), brake)
        both = np.concatenate([brake, np.zeros(len(carried.others.number))])
        both = np.where(met.braking, np.maximum(both, section.oncoming_decel_mps2), both)
        both = np.where(met.wrecked, WRECK_BRAKE_MPS2, both)
        who = np.concatenate([rows, carried.others.number]).astype(np.int32)
        others = np.arange(len(who)) >= count
        order = np.full(len(who), CommandKind.BRAKE, np.int32)
        order[:count][driven] = CommandKind.STEER
        order[met.expired] = CommandKind.REMOVE
        told = (order != CommandKind.BRAKE) | (both > 0.0)
        # Those that were told to leave are still in the next step; then somebody else may have their row.
        told[:count] &= ~np.isin(rows, list(self._taken_away))
        self._taken_away.update(rows[met.expired[:count]].tolist())
        lateral_m = np.zeros(len(who))
        lateral_m[:count][driven] = steered.offset_m[rows[driven]]
        released = wishes.released
        return Commands(
            rows=np.concatenate([released, who[told]]).astype(np.int32),
            others=np.concatenate([np.zeros(len(released), np.bool_), others[told]]),
            order=np.concatenate([np.full(len(released), CommandKind.RELEASE, np.int32), order[told]]),
            lateral_m=np.concatenate([np.zeros(len(released)), lateral_m[told]]),
            brake_mps2=np.concatenate([np.zeros(len(released)), both[told]]),
        )

    def write(self, folder: Path, projector: Projector) -> Mapping[str, Any]:
        """Write the tables, after those of the run; return figures for the manifest."""
        self._happened.close(dict(self._names), KIND_NAMES)
        carried, totals = self._carried, self._happened.totals
        lost_s = carried.lost_s if carried else 0.0
        end = WorldEnd(
            totals=totals,
            collisions=self._collisions.rows(projector),
            stories=self._happened.stories,
            delay_s=lost_s / max(totals.vehicles, 1),
            ttc=self._critical[0],
            drac=self._critical[1],
            mrm=totals.stops if self._key.on_alarm == "handover" else 0,
            stuck=carried.stuck if carried else 0,
            removed=carried.removed if carried else 0,
            surplus_share=self._surplus[0] / max(self._surplus[1], 1),
        )
        write_world(folder, self._key, end, self._step_s)
        write_kept(folder, self._key, self._kept.tables)
        return {
            "net": {"projection": projector.definition, "offset_m": list(projector.offset_m)},
            "teleports": carried.teleports if carried else 0,
            "steered_vehicle_steps": self._surplus[1],
            "command_us_per_steered_vehicle_step": 1e6 * carried.spent_s / self._surplus[1]
            if carried and self._surplus[1]
            else None,
        }


def _tracks_of(rows: Ints, loop: Loop) -> Ints:
    """Return (n,) the one track of each vehicle row."""
    tracks = loop.tracks
    of_vehicle = np.full(len(loop.vehicles.lane), -1, np.int32)
    of_vehicle[tracks.vehicle[loop.track_rows]] = loop.track_rows
    return of_vehicle[rows]


def blind_off_the_lane(rows: Ints, vehicles: Vehicles) -> None:
    """Let cameras see no lane where the rear axle is well beyond the line of the lane that they would show.

    SUMO's lane is one of the vehicle's own edge: beside it, a camera would look at lines of oncoming lanes or at none.
    """
    off_m = np.abs(vehicles.camera_offset_m[rows]) - 0.5 * vehicles.lane_width_m[rows]
    vehicles.marked[rows] &= off_m <= _SEEN_M
