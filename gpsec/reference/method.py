"""The reference engine: lanes, residual, detectors and filters of one track after another."""

from copy import deepcopy

from gpsec.association.associating import Associating
from gpsec.attacks.probing import Probed, Question
from gpsec.core.arrays import Ints
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.base import Detection
from gpsec.filters.noise import noise_of
from gpsec.hdmap.map import HDMap
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.reference.history import Rules
from gpsec.reference.monitor import TrackMonitor
from gpsec.reference.perception import Perceived, ReferencePerception, TrackPerception
from gpsec.reference.probing import OwnCopies, Trials, without_errors
from gpsec.reference.switch import TrackLocalization
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class ReferenceTrack:
    """One vehicle under one attack plan: its detectors and its filters.

    Attributes:
        perception: lane, residuals, monitor and detectors.
        localization: the filters of all defences.

    """

    def __init__(self, perception: TrackPerception, localization: TrackLocalization) -> None:
        self.perception = perception
        self.localization = localization

    @property
    def monitor(self) -> TrackMonitor | None:
        """What watches its fixes, if a detector reads it."""
        return self.perception.monitor


class ReferenceMethod:
    """One plain object for each track, by hand from filterpy, shapely and torch.

    Implements `gpsec.types.method.Method`.
    """

    def __init__(
        self,
        hd_map: HDMap,
        world: World,
        association: Associating,
        detection: Detection,
        localization: Localization,
        *,
        copies: bool = False,
    ) -> None:
        """Prepare for tracks; with `copies`, an attacker follows each with detectors of its own.

        Raises:
            GpsecError: there is no reference of a detector or response.

        """
        self._world = world
        self._localization = localization
        self._perception = ReferencePerception(hd_map, world, association, detection)
        self._trials = Trials(self._perception, detection)
        self._own = OwnCopies(self._perception) if copies else None
        self._tracks: dict[int, ReferenceTrack] = {}
        self._new_localization(0)  # says now, rather than with the first vehicle, what is missing
        lengths = {"detectors": len(detection.names), "defences": len(localization.responses)}
        self._answers = Table(Answers, **lengths)

    @property
    def answers(self) -> Answers:
        """The results of the last step."""
        return self._answers.now

    def track(self, row: int) -> ReferenceTrack:
        """Return the object of a track row in use, for comparisons."""
        return self._tracks[row]

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        self._answers.grow(capacity)
        if self._own is not None:
            self._own.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Reset the track rows `rows`."""
        self._answers.reset(rows)
        for row in rows.tolist():
            self._tracks.pop(row, None)
        if self._own is not None:
            self._own.reset(rows)

    def copy(self, source: Ints, target: Ints) -> None:
        """Copy the state of the tracks `source` to the tracks `target`."""
        self._answers.copy(source, target)
        for one, other in zip(source.tolist(), target.tolist(), strict=True):
            self._tracks.pop(other, None)
            if one in self._tracks:
                self._tracks[other] = deepcopy(self._tracks[one])
        if self._own is not None:
            self._own.copy(source, target)

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
        """Take step `number` of the track rows `rows`, one after another; `threads` are not used."""
        for row in rows.tolist():
            profile = int(vehicles.profile[tracks.vehicle[row]])
            if row not in self._tracks:
                self._tracks[row] = ReferenceTrack(self._perception.new_track(profile), self._new_localization(profile))
            perceived = self._perception.step(number, self._tracks[row].perception, row, tracks, vehicles, seen)
            self._answer(row, perceived, profile)
        if self._own is not None:
            self._own.follow(number, rows, tracks, vehicles, seen)
        watch.lap("reference engine")

    def probe(
        self, number: int, asked: Question, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads
    ) -> Probed:
        """Return what detectors would find of other fixes in step `number`, which has not been taken yet."""
        if not asked.own_copy:
            known = {row: self._tracks[row].perception for row in asked.rows.tolist()}
            return self._trials.ask(number, asked, known, tracks, vehicles, seen)
        if self._own is None:
            raise ValueError("expected a method with copies for an attacker who asks its own")
        own, exact = self._own, without_errors(vehicles, seen)
        return self._trials.ask(number, asked, own.perceptions, own.tracks, vehicles, exact)

    def _answer(self, row: int, perceived: Perceived, profile: int) -> None:
        track, answers = self._tracks[row], self.answers
        for k, verdict in enumerate(perceived.verdicts):
            answers.statistic[row, k] = verdict.statistic
            answers.scored[row, k] = verdict.scored
            answers.alarm[row, k] = verdict.alarm
        alarms, matcher = answers.alarm[row].tolist(), self._perception.matchers[profile]
        track.localization.step(perceived.sight, alarms, perceived.residual, matcher)
        for d, defence in enumerate(track.localization.defences):
            answers.estimate_m[row, d] = defence.position_m
            answers.isolated[row, d] = defence.isolated

    def _new_localization(self, profile: int) -> TrackLocalization:
        table, localization = self._world.noise, self._localization
        rules = Rules(noise_of(table, profile), localization.settings, self._world.step_s)
        return TrackLocalization(
            localization.detector.tolist(), [response.name for response in localization.responses], rules
        )
