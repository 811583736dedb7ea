"""What becomes of encounters, step by step: hits, wrecks, critical moments, and drivers who brake."""

from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, blank
from gpsec.encounters.meeting import CRITICAL_DRAC_MPS2, CRITICAL_TTC_S, Kind, directions, needed_braking
from gpsec.encounters.pairs import ClosePairs, close_pairs
from gpsec.encounters.rectangles import Bodies

# A touch that is slower does not stop anybody, and is counted apart.
SLOW_MPS = 1.0
# A threat that is gone for this long is over: courses turn in and out of each other while somebody swerves.
_FORGOTTEN_S = 1.0


@dataclass(frozen=True)
class EncounterRules:
    """How people react, and what is left of a crash.

    Attributes:
        step_s: length of a step.
        oncoming_reaction_s: from when a driver could see that a vehicle comes at them until they brake.
        wreck_s: a wreck stands for so long, then it is taken away.
    """

    step_s: float
    oncoming_reaction_s: float
    wreck_s: float

    def steps(self, seconds: float) -> int:
        """Return how many steps `seconds` take."""
        return ceil(seconds / self.step_s - 1e-6)


class Involved(NamedTuple):
    """What is remembered of the people on the road; the row is a person's number.

    Attributes:
        wreck_step: (N,) step of the crash, -1 for none.
        threat_step: (N,) step in which the present threat was first there, -1 for none.
        seen_step: (N,) step in which it was there last.
    """

    wreck_step: Ints = blank(-1)
    threat_step: Ints = blank(-1)
    seen_step: Ints = blank(-1)


@dataclass(frozen=True)
class People:
    """Who is on the road in a step; B of them.

    Attributes:
        number: (B,) of each, the same for as long as they are on the road.
        bodies: of each.
        driven: (B,) gpsec has a hand in how they drive; what SUMO's own vehicles do among themselves is no encounter.
        astray: (B,) out of their lane.
    """

    number: Ints
    bodies: Bodies
    driven: Flags
    astray: Flags


@dataclass(frozen=True)
class Hits:
    """Hits of a step, H of them.

    Attributes:
        first, second: (H,) positions among the people of the step.
        kind: (H,) `Kind`; WRECK where one of the two was one before.
        closing_mps: (H,) size of the relative velocity.
    """

    first: Ints
    second: Ints
    kind: Ints
    closing_mps: Floats


@dataclass(frozen=True)
class Met:
    """What a step came to.

    Attributes:
        hits: first touches of two people, one of whom gpsec drives, or is a wreck.
        critical_ttc, critical_drac: pairs that began to be nearer than `CRITICAL_TTC_S`, or to need more than
            `CRITICAL_DRAC_MPS2`.
        wrecked: (B,) is a wreck.
        expired: (B,) has been one for long enough.
        braking: (B,) brakes for somebody who comes at them.
    """

    hits: Hits
    critical_ttc: int
    critical_drac: int
    wrecked: Flags
    expired: Flags
    braking: Flags


class Encounters:
    """The encounters of a run."""

    def __init__(self, rules: EncounterRules) -> None:
        self._rules = rules
        self._involved = Table(Involved)
        self._touching: frozenset[int] = frozenset()
        self._critical: tuple[frozenset[int], frozenset[int]] = (frozenset(), frozenset())

    def forget(self, numbers: Ints) -> None:
        """Let (n,) numbers be those of somebody else from now on."""
        self._involved.reset(numbers[numbers < self._involved.capacity])

    def update(self, step: int, people: People) -> Met:
        """Take in a step."""
        number = people.number
        self._involved.grow(int(number.max(initial=0)) + 1)
        pairs = close_pairs(people.bodies)
        kinds = directions(people.bodies, pairs)
        counted = self._counted(people, pairs)
        hits = self._hit(step, people, pairs, kinds, counted)
        ttc, drac = self._note_critical(people, pairs, counted)
        braking = self._threatened(step, people, pairs, kinds)
        wreck_step = self._involved.now.wreck_step[number]
        wrecked = wreck_step >= 0
        return Met(
            hits=hits,
            critical_ttc=ttc,
            critical_drac=drac,
            wrecked=wrecked,
            expired=wrecked & (step - wreck_step >= self._rules.steps(self._rules.wreck_s)),
            braking=braking & ~wrecked,
        )

    def _counted(self, people: People, pairs: ClosePairs) -> Flags:
        """Return (C,) whether a pair is an encounter of gpsec's, and not one of two wrecks."""
        wrecked = self._involved.now.wreck_step[people.number] >= 0
        i, j = pairs.first, pairs.second
        ours = people.driven | wrecked
        return np.asarray((ours[i] | ours[j]) & ~(wrecked[i] & wrecked[j]))

    def _hit(self, step: int, people: People, pairs: ClosePairs, kinds: Ints, counted: Flags) -> Hits:
        touching = _keys(people.number, pairs, pairs.gap_m < 0.0)
        new = np.array([key not in self._touching for key in touching.tolist()], np.bool_)
        self._touching = frozenset(touching.tolist())
        chosen = np.flatnonzero(pairs.gap_m < 0.0)[new]
        chosen = chosen[counted[chosen]]
        i, j = pairs.first[chosen], pairs.second[chosen]
        involved = self._involved.now
        wrecked = (involved.wreck_step[people.number[i]] >= 0) | (involved.wreck_step[people.number[j]] >= 0)
        closing = pairs.closing_mps[chosen]
        hard = closing >= SLOW_MPS
        crashed = people.number[np.concatenate([i[hard], j[hard]])]
        crashed = crashed[involved.wreck_step[crashed] < 0]
        involved.wreck_step[crashed] = step
        return Hits(i, j, np.where(wrecked, Kind.WRECK, kinds[chosen]).astype(np.int32), closing)

    def _note_critical(self, people: People, pairs: ClosePairs, counted: Flags) -> tuple[int, int]:
        ahead = counted & (pairs.gap_m >= 0.0)
        now = (
            frozenset(_keys(people.number, pairs, ahead & (pairs.contact_s < CRITICAL_TTC_S)).tolist()),
            frozenset(_keys(people.number, pairs, ahead & (needed_braking(pairs) > CRITICAL_DRAC_MPS2)).tolist()),
        )
        begun = len(now[0] - self._critical[0]), len(now[1] - self._critical[1])
        self._critical = now
        return begun

    def _threatened(self, step: int, people: People, pairs: ClosePairs, kinds: Ints) -> Flags:
        """Return (B,) who brakes: their reaction time ago, somebody astray began to come at them, and still does."""
        i, j = pairs.first, pairs.second
        head_on = (kinds == Kind.ONCOMING) & (people.astray[i] != people.astray[j])
        victim = np.where(people.astray[i], j, i)[head_on]
        involved, number = self._involved.now, people.number
        forgotten = self._rules.steps(_FORGOTTEN_S)
        over = number[(involved.seen_step[number] >= 0) & (step - involved.seen_step[number] > forgotten)]
        involved.threat_step[over] = involved.seen_step[over] = -1
        new = number[victim]
        involved.seen_step[new] = step
        fresh = new[involved.threat_step[new] < 0]
        involved.threat_step[fresh] = step
        since = involved.threat_step[number]
        return np.asarray((since >= 0) & (step - since >= self._rules.steps(self._rules.oncoming_reaction_s)))


def _keys(number: Ints, pairs: ClosePairs, chosen: Flags) -> np.ndarray:
    """Return one integer for each of the `chosen` pairs, the same in every step."""
    a, b = number[pairs.first[chosen]].astype(np.int64), number[pairs.second[chosen]].astype(np.int64)
    return np.asarray((np.minimum(a, b) << 32) | np.maximum(a, b))
