"""The fleet in motion: vehicles come and go, are sensed and spoofed; each vehicle × plan is a track."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gpsec.attacks.knowledge import note_deviation
from gpsec.attacks.schedule import NEVER, Clock, Plan, Schedule
from gpsec.core import noise
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Slots, Table
from gpsec.core.threads import Threads
from gpsec.hdmap.locating import locate
from gpsec.outcomes.recorder import Outcomes
from gpsec.outcomes.samples import SampleTable
from gpsec.pipeline.loop_settings import LoopSettings
from gpsec.pipeline.perception import StepInputs
from gpsec.pipeline.spoofing import Spoofing
from gpsec.traffic.body import axle_distance
from gpsec.traffic.source import Frame
from gpsec.types.method import Method
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity, Measurements, Vehicles


class Loop:
    """Truth, sensors and spoofed fixes of all vehicles, step by step.

    Attributes:
        fleet: who each vehicle row in use stands for.
        eyes: those of them whose lanes come from pictures, None for nobody's.
        track_rows: rows in use, ascending.
        attacks: attacks begun so far, for each plan.

    """

    def __init__(
        self,
        settings: LoopSettings,
        plans: Sequence[Plan],
        method: Method,
        outcomes: Outcomes | None = None,
        threads: Threads | None = None,
        watch: Stopwatch | None = None,
    ) -> None:
        """Begin with empty roads; tracks that are over are handed to `outcomes`, whose rows go along with theirs."""
        self._vehicles = Table(Vehicles)
        self._seen = Table(Measurements)
        self._tracks = Table(Tracks)
        self.fleet: dict[int, Identity] = {}
        self.track_rows: Ints = np.zeros(0, np.int32)
        self.attacks = [0] * len(plans)
        self._seed = settings.seed
        self._clock = Clock(settings.step_s, settings.origin_s)
        self._settle_steps = int(np.ceil(settings.settle_s / settings.step_s - 1e-6))
        self._roads = settings.hd_map.roads(np.zeros(1, np.int32))
        self._mistakes = settings.mistakes
        self._move = settings.move
        self._look, self._forks = settings.look, settings.forks
        self._visibility = settings.visibility
        self.eyes = None if settings.pixels is None else settings.pixels.start()
        self._sensors = settings.sensors
        self._sensor_state = settings.sensors.new_state(1)
        self._shared = settings.shared
        self._common = None if self._shared is None else self._shared.new_state()
        self._profile_of = settings.profile_of
        self._plans = list(plans)
        self._schedules = [Table(Schedule) for _ in plans]
        # Before it, no attack of a plan begins or ends.
        self._due_step = [NEVER] * len(self._plans)
        self._spoofing = Spoofing(settings, self._plans, method)
        self._method = method
        self._outcomes = outcomes
        self._threads = threads or Threads(1)
        self._watch = watch or Stopwatch()
        self._slots = Slots()
        self._tracks_of: dict[int, list[int]] = {}
        self._used = np.zeros(1, np.bool_)

    @property
    def vehicles(self) -> Vehicles:
        """Truth of the vehicles."""
        return self._vehicles.now

    @property
    def seen(self) -> Measurements:
        """What their sensors gave in this step."""
        return self._seen.now

    @property
    def tracks(self) -> Tracks:
        """Each vehicle under each plan."""
        return self._tracks.now

    def step(self, frame: Frame) -> None:
        """Take in one step of the traffic and run the method on it."""
        self._leave(frame)
        self._depart(frame)
        rows, vehicles = frame.rows, self.vehicles
        vehicles.lane[rows] = frame.lane
        self._move(frame, self._clock.step_s, vehicles)
        self._threads.run(locate, rows, frame.step, self._clock.step_s, self._roads, self._mistakes, vehicles)
        if self.eyes is not None:
            self._watch.lap("truth")
            self.eyes.look(frame, vehicles)
            self._watch.lap("pictures")
        if self._look is not None:
            self._look(rows, vehicles)
        if self._visibility is not None:
            self._visibility.limit(rows, vehicles, self._threads)
        self._watch.lap("truth")
        self._sensors.sense(self._sensor_state, vehicles, self.seen, rows, frame.step, self._threads)
        if self.eyes is not None:
            self.eyes.show(vehicles, self.seen)
        if self._shared is not None and self._common is not None:
            self._shared.disturb(self._common.now, rows, frame.step, vehicles, self.seen)
        self._spoofing.note_fixes(rows, frame.step, self.seen)
        self._watch.lap("sensors")
        self._move_plans(frame)
        inputs = StepInputs(frame.step, self.tracks, vehicles, self.seen, self._threads)
        self._spoofing.spoof(self.track_rows, inputs)
        self._watch.lap("attacks")
        self._method.step(frame.step, self.track_rows, self.tracks, vehicles, self.seen, self._threads, self._watch)
        estimate_m = self._method.answers.estimate_m
        self._threads.run(note_deviation, self.track_rows, self.tracks, vehicles, estimate_m)
        self._watch.lap("attacks")

    def finish(self) -> None:
        """Close the tracks of all vehicles that are still on the road."""
        self._close(self.track_rows, None)

    def _close(self, rows: Ints, ended_s: float | None) -> None:
        """Hand over track rows that are over, before they are used again."""
        if self._outcomes is not None:
            people = [self.fleet[row] for row in self.tracks.vehicle[rows].tolist()]
            self._outcomes.close(rows, self.tracks, people, ended_s)

    def _leave(self, frame: Frame) -> None:
        over = [track for row in frame.left for track in self._tracks_of.pop(row)]
        if not over:
            return
        over.sort()
        closed = np.array(over, np.int32)
        self._close(closed, frame.time_s)
        self._used[closed] = False
        for track in over:
            self._slots.give_back(track)
        if self.eyes is not None:
            self.eyes.leave(frame.left)
        for row in frame.left:
            del self.fleet[row]
        self._refresh_rows()

    def _depart(self, frame: Frame) -> None:
        if not frame.departures:
            return
        new = np.array([departure.row for departure in frame.departures], np.int32)
        self._make_room(int(new.max()) + 1)
        for rows in self._vehicle_states():
            rows.reset(new)
        vehicles = self.vehicles
        for departure in frame.departures:
            row = departure.row
            profile = self._profile_of(departure)
            self.fleet[row] = Identity(
                departure.vehicle_id, departure.vehicle_type, profile, frame.time_s, departure.first_id
            )
            vehicles.key[row] = noise.vehicle_key(self._seed, departure.vehicle_id)
            vehicles.profile[row] = profile
            vehicles.axle_m[row] = axle_distance(departure.length_m)
            vehicles.length_m[row] = departure.length_m
            vehicles.width_m[row] = departure.width_m
            vehicles.yaw_rad[row] = departure.yaw_rad
            vehicles.speed_mps[row] = departure.speed_mps
            vehicles.born_step[row] = frame.step
            self._tracks_of[row] = []
        self._sensors.enter(self._sensor_state, vehicles, new, frame.step)
        if self.eyes is not None:
            self.eyes.enter(frame.departures, vehicles)
        tracks = self._new_tracks(new)
        for table in self._track_states():
            table.reset(tracks)
        self._method.reset(tracks)
        self.tracks.vehicle[tracks] = new
        people = [(departure.vehicle_type, departure.first_id) for departure in frame.departures]
        for number, (plan, schedule) in enumerate(zip(self._plans, self._schedules, strict=True)):
            aimed = np.array([plan.aims_at(*who) for who in people])
            settled = frame.step + self._settle_steps
            plan.enter(schedule.now, new, vehicles.key[new], aimed, settled, self._clock)
            self._due_step[number] = min(self._due_step[number], plan.due_step(schedule.now, new))
        self._refresh_rows()

    def _move_plans(self, frame: Frame) -> None:
        """Begin and end attacks; a beginning attack forks the benign track of its vehicle."""
        rows, step = frame.rows, frame.step
        tracks = self.tracks
        age = step - self.vehicles.born_step[tracks.vehicle[self.track_rows]]
        tracks.settled[self.track_rows] = age >= self._settle_steps
        begun: dict[int, Ints] = {}
        for number, (plan, schedule) in enumerate(zip(self._plans, self._schedules, strict=True), start=1):
            if step < self._due_step[number - 1]:
                continue
            starting, ending = plan.advance(schedule.now, rows, self.vehicles.rear_m, step, frame.spoofers_m)
            self._due_step[number - 1] = plan.due_step(schedule.now, rows)
            if len(ending):
                ended = np.array([self._track(row, number) for row in ending.tolist()], np.int32)
                tracks.attacked[ended] = False
                tracks.end_step[ended] = step
            self.attacks[number - 1] += len(starting)
            if len(starting):
                begun[number] = starting
        if begun:
            self._fork(begun, step)

    def _fork(self, begun: Mapping[int, Ints], step: int) -> None:
        """Fork the benign track of the vehicle rows whose attack begins, by the number of the plan."""
        vehicle_rows = np.concatenate(list(begun.values()))
        source = np.array([self._track(row, 0) for row in vehicle_rows.tolist()], np.int32)
        forked = self._new_tracks(vehicle_rows) if self._forks else source
        if self._forks:
            for table in self._track_states():
                table.copy(source, forked)
            self._method.copy(source, forked)
        tracks = self.tracks  # the table may have grown
        tracks.plan[forked] = np.repeat(list(begun), [len(rows) for rows in begun.values()])
        tracks.attacked[forked] = True
        tracks.start_step[forked] = step
        for number in begun:
            self._spoofing.begin(number, forked[tracks.plan[forked] == number])
        self._refresh_rows()

    def _track(self, vehicle_row: int, plan: int) -> int:
        return next(track for track in self._tracks_of[vehicle_row] if self.tracks.plan[track] == plan)

    def _new_tracks(self, vehicle_rows: Ints) -> Ints:
        taken = [self._slots.take() for _ in range(len(vehicle_rows))]
        if self._slots.used > self._tracks.capacity:
            capacity = 2 * self._slots.used
            for table in self._track_states():
                table.grow(capacity)
            self._method.grow(capacity)
            self._spoofing.grow(capacity)
            self._used = np.concatenate([self._used, np.zeros(capacity - len(self._used), np.bool_)])
        for vehicle, track in zip(vehicle_rows.tolist(), taken, strict=True):
            self._tracks_of[vehicle].append(track)
        rows = np.array(taken, np.int32)
        self._used[rows] = True
        return rows

    def _make_room(self, vehicle_rows: int) -> None:
        if vehicle_rows > self._vehicles.capacity:
            for rows in self._vehicle_states():
                rows.grow(2 * vehicle_rows)

    def _refresh_rows(self) -> None:
        self.track_rows = np.flatnonzero(self._used).astype(np.int32)

    def _vehicle_states(self) -> list[Table[Any]]:
        return [self._vehicles, self._seen, self._sensor_state, self._spoofing.history, *self._schedules]

    def _track_states(self) -> list[Table[Any] | SampleTable]:
        return [self._tracks] if self._outcomes is None else [self._tracks, *self._outcomes.tables()]
