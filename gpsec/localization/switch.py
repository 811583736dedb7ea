"""The switch between normal operation and isolation, for every defence of every track.

On an alarm, or when fixes stop coming, a defence isolates GNSS. It re-joins when its detector has been quiet for
`hold_s` and fixes have agreed with what the vehicle knows for `rejoin_s`: laterally by the residual, along the lane by
the distance from the estimate to the fix that the residual is of, carried on to now.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Flags, Ints
from gpsec.core.kernels import kernel
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.localization.branches import BranchRows, LocalizationState
from gpsec.localization.family import Filter, advancing
from gpsec.localization.history import SNAPSHOTS, Beliefs, History, Recall, record_step
from gpsec.localization.rejoin import SwitchRules, SwitchSettings, judging, trusting
from gpsec.localization.responses import Response
from gpsec.localization.state import TRUSTS, Cells, Defences, report_estimates
from gpsec.localization.world import World
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Fixes count as lost after this many periods, whatever `outage_s` says.
_OUTAGE_PERIODS = 2.5


@dataclass(frozen=True)
class Family:
    """The defences of one filter.

    Attributes:
        filter: what they have in common.
        rolls_back: whether they go back in time, all of them or none.
        defences: which they are.
        responses: their responses that isolate, with their numbers.
    """

    filter: Filter
    rolls_back: bool
    defences: Defences
    responses: Sequence[tuple[int, Response]]


class Localization:
    """Runs the filters of all defences.

    Attributes:
        detector: (D,) column of the alarm that each defence listens to.
        responses: its response.
        world, settings: what they work with.
        recall: how far back responses go that roll back.
        families: the defences by filter.
    """

    def __init__(self, detector: Ints, responses: list[Response], world: World, settings: SwitchSettings) -> None:
        self.detector = detector
        self.responses = responses
        self.world = world
        self.settings = settings
        self.recall = Recall.over(settings.rollback_s, world.step_s)
        lost_after_s = np.maximum(settings.outage_s, _OUTAGE_PERIODS * world.noise.gnss_period_s)
        self._rules = SwitchRules(world.step_s, settings.hold_s, settings.rejoin_s, lost_after_s)
        kinds = list(dict.fromkeys(responses))
        numbers = [kinds.index(one) if one.isolates else TRUSTS for one in responses]
        self._defences = Defences(np.arange(len(responses), dtype=np.int32), detector, np.array(numbers, np.int32))
        sorts = [(one.filter, one.rolls_back) for one in responses]
        self.families = [self._family(*sort, kinds, [one == sort for one in sorts]) for sort in dict.fromkeys(sorts)]
        self._goes_back = any(one.rolls_back for one in responses)

    def _family(self, filter_: Filter, rolls_back: bool, kinds: list[Response], of_it: list[bool]) -> Family:
        chosen = np.array(of_it)
        defences = Defences(*(column[chosen] for column in self._defences))
        numbers = sorted(set(defences.response.tolist()) - {TRUSTS})
        return Family(filter_, rolls_back, defences, [(number, kinds[number]) for number in numbers])

    def new_state(self, capacity: int) -> LocalizationState:
        """Return the state of `capacity` track rows; each has filters from when it is reset."""
        families = [
            BranchRows(family.defences.column, family.filter.states, SNAPSHOTS * family.rolls_back)
            for family in self.families
        ]
        kept = self.recall.steps if self._goes_back else 0
        history, beliefs = Table(History, steps=kept), Table(Beliefs, steps=kept)
        state = LocalizationState(len(self.responses), families, history, beliefs)
        state.grow(capacity)
        return state

    def propagate(
        self,
        state: LocalizationState,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        alarm: Flags,
        threads: Threads,
    ) -> None:
        """Isolate who has to be, move all estimates on, and correct those that trust GNSS.

        `rows` are the track rows in use, `alarm` is (M, K).
        """
        world, cells, profile = self.world, state.cells, vehicles.profile
        if self._goes_back:
            record_step(rows, state.history, state.beliefs, tracks, vehicles, seen)
        threads.run(isolate_on_alarm, rows, cells, self._defences, alarm, tracks, profile, self._rules)
        for branches, entered in zip(state.families, state.part(rows), strict=True):
            branches.now.entered[entered] = True
        for family, branches in zip(self.families, state.families, strict=True):
            branches.activate(rows, len(cells.lost))
            advance = advancing(family.filter)
            threads.run(advance, branches.active, branches.now, cells, tracks, profile, seen, world.noise, self.recall)

    def correct(
        self,
        state: LocalizationState,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
    ) -> None:
        """Correct the isolated estimates of the track rows `rows`, and take GNSS back where it is time."""
        world, cells, profile, anybody = self.world, state.cells, vehicles.profile, False
        for family, branches in zip(self.families, state.families, strict=True):
            isolated = branches.active[branches.now.response[branches.active] >= 0]
            if not len(isolated):
                continue
            anybody = True
            for number, response in family.responses:
                chosen = isolated[branches.now.response[isolated] == number]
                if not len(chosen):
                    continue
                if family.rolls_back:
                    self._rewind(response, chosen, state, branches, tracks, vehicles, threads)
                threads.run(response.correct, chosen, branches.now, tracks, vehicles, seen, world)
            judge, defences, rules = judging(family.filter), family.defences, self._rules
            threads.run(judge, isolated, branches.now, cells, defences, tracks, profile, world.noise, rules)
        if not anybody:
            return
        for family, branches, joining in zip(self.families, state.families, state.part(rows), strict=True):
            if len(joining):
                threads.run(trusting(family.filter), joining, branches.now, tracks, profile, world.noise)

    def _rewind(
        self,
        response: Response,
        rows: Ints,
        state: LocalizationState,
        branches: BranchRows,
        tracks: Tracks,
        vehicles: Vehicles,
        threads: Threads,
    ) -> None:
        """Let branches go back that an alarm has isolated in this step; fixes that were lost have spoilt nothing."""
        now = branches.now
        back = rows[now.entered[rows] & ~state.cells.lost[now.track[rows]]]
        if len(back):
            threads.run(response.rewind, back, now, tracks, vehicles, state.recorded, self.world, self.recall)

    def report(self, state: LocalizationState, rows: Ints, answers: Answers, threads: Threads) -> None:
        """Set estimates and flags of isolation of the track rows `rows`."""
        for family, branches in zip(self.families, state.families, strict=True):
            threads.run(report_estimates, rows, state.cells, branches.now, family.defences.column, answers)


@kernel
def isolate_on_alarm(
    rows: Ints,
    cells: Cells,
    defences: Defences,
    alarm: Flags,
    tracks: Tracks,
    profile: Ints,
    rules: SwitchRules,
) -> None:
    """Give GNSS up where the detector of a defence raises an alarm, or where fixes have stopped coming."""
    for row in rows:
        if not cells.started[row]:
            cells.started[row] = tracks.fix_valid[row]
            continue
        cells.fix_age_s[row] = 0.0 if tracks.fix_valid[row] else cells.fix_age_s[row] + rules.step_s
        lost = cells.fix_age_s[row] > rules.lost_after_s[profile[tracks.vehicle[row]]]
        cells.lost[row] = lost
        for d in range(len(defences.column)):
            cells.alarm[row, d] = alarm[row, defences.detector[d]]
            heeds = defences.response[d] >= 0 and cells.response[row, d] < 0
            if heeds and (cells.alarm[row, d] or lost):
                cells.response[row, d] = defences.response[d]
                cells.quiet_s[row, d] = 0.0
                cells.parts[row] = True
