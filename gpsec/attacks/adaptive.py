"""Adaptive: an attacker who knows the detector moves the fix as far as it will let pass."""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema

from gpsec.attacks.base import DirectedAttack, Spoofed, Victims
from gpsec.attacks.probing import Knowledge
from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import blank

_ALL = "all"
# Displacements that are tried in a step: between now and the furthest, from now back to none, and beyond.
_AHEAD, _BACK = np.arange(16, 0, -1) / 16.0, np.arange(24, -1, -1) / 24.0
_BEYOND = np.array([1.0, 2.0, 4.0, 8.0])
TRIED = len(_AHEAD) + len(_BACK) + len(_BEYOND)
# Who is told alarms only goes back to this share of its displacement when there would be one; its strides are halved
# until they are shorter.
_RETREAT, _SHORTEST_M = 0.5, 1e-3


def _names(value: object) -> object:
    """Return the names in a text, which commas part, or those of a list."""
    if isinstance(value, str):
        value = value.split(",")
    if not isinstance(value, Iterable) or not all(isinstance(name, str) and name.strip() for name in value):
        raise ValueError(f"expected a detector, a list of them, or '{_ALL}', found {str(value)[:60]!r}")
    names = tuple(name.strip() for name in value)
    if not names or (_ALL in names and len(names) > 1):
        raise ValueError(f"expected a detector, a list of them, or '{_ALL}', found {str(list(names))[:60]}")
    return names


_SCHEMA = {"anyOf": [{"type": "string"}, {"items": {"type": "string"}, "type": "array"}], "default": _ALL}


class AdaptiveState(NamedTuple):
    """What was done to M tracks.

    Attributes:
        moved_m: (M,) displacement of the last fix.
        hidden_m: (M,) the largest that a detector has scored and let pass, at the last score.
        stride_m: (M,) by how much who is told alarms only dares to go on, negative before the first step.
        asked: (M,) answers that it has had.
    """

    moved_m: Floats = blank(0.0)
    hidden_m: Floats = blank(0.0)
    stride_m: Floats = blank(-1.0)
    asked: Ints = blank(0)


class Adaptive(DirectedAttack):
    """Each fix is moved as far as the detectors that it targets will let pass, and a little further in every step.

    Before a fix is sent, 45 displacements are tried on a copy of what the detectors remember, up to `growth_m` beyond
    the last and back to none. The largest is sent whose statistic is at most `level` of the threshold, or if there is
    none that whose statistic is least. Where nothing is scored, the displacement stays, and once the camera sees a lane
    again it is what passed before.

    Attributes:
        target: detector that must not notice, at the headline rate, or an operating point such as `lstm@1/h`; a list of
            some, or `all` of the run.
        level: share of the threshold that the statistic is brought to.
        growth_m: by how much the displacement grows at most from one fix to the next.
        knowledge: `white` knows all that the detector knows; `grey` runs a detector of the same make, with the same
            thresholds, on the true motion of the vehicle, and does not know what its sensors say; `queries` is told
            whether there would be an alarm, and nothing else, `budget` times: with one the displacement is halved.
        budget: answers that each attack has, for `queries`.
        junctions: inside junctions, where no lane is marked, `hold` keeps the displacement; `move` lets it grow by
            `junction_growth_m` from one fix to the next, as far as nothing there scores it above the level.
        junction_growth_m: see there.
        cap_m: largest displacement.
    """

    name: ClassVar[str] = "adaptive"
    state: ClassVar[type[Any]] = AdaptiveState
    target: Annotated[tuple[str, ...], BeforeValidator(_names), WithJsonSchema(_SCHEMA)] = (_ALL,)
    level: float = Field(0.95, gt=0.0, le=1.0)
    growth_m: float = Field(0.05, gt=0.0, le=10.0)
    knowledge: Literal["white", "grey", "queries"] = "white"
    budget: int = Field(50, ge=1, le=1_000_000)
    junctions: Literal["hold", "move"] = "hold"
    junction_growth_m: float = Field(0.5, gt=0.0, le=100.0)
    cap_m: float = Field(10.0, gt=0.0, le=10_000.0)

    def known(self) -> Knowledge:
        """Return of which detectors it knows what they find."""
        return Knowledge(() if self.target == (_ALL,) else self.target, self.knowledge == "grey")

    def spoof(self, victims: Victims, state: AdaptiveState) -> Spoofed:
        """Return fix + the largest displacement that is let pass."""
        rows, there = victims.rows, victims.fix_valid
        direction = self.direction(victims)
        free = victims.blind if self.junctions == "move" else np.zeros_like(victims.blind)
        choose = self._by_alarms if self.knowledge == "queries" else self._by_statistics
        moved_m = choose(victims, state, direction, free)
        state.moved_m[rows] = np.where(there, moved_m, state.moved_m[rows])
        return self.displace(victims, state.moved_m[rows])

    def _by_statistics(self, victims: Victims, state: AdaptiveState, direction: Floats, free: Flags) -> Floats:
        """Return (m,) displacements of an attacker who is told statistics; `free` are those who may move unseen."""
        rows = victims.rows
        before = state.moved_m[rows, np.newaxis]
        growth = np.where(free, self.junction_growth_m, self.growth_m)[:, np.newaxis]
        beyond = np.broadcast_to(-self.growth_m * _BEYOND, (len(rows), len(_BEYOND)))
        tried = np.minimum(np.concatenate([before + growth * _AHEAD, before * _BACK, beyond], axis=1), self.cap_m)
        found = victims.probe(tried[:, :, np.newaxis] * direction[:, np.newaxis, :])
        scored = found.scored & victims.fix_valid[:, np.newaxis]
        seen, furthest = scored.any(axis=1), tried.max(axis=1)
        passes = np.where(scored & (found.ratio <= self.level), tried, -np.inf).max(axis=1)
        least = tried[np.arange(len(rows)), np.where(scored, found.ratio, np.inf).argmin(axis=1)]
        judged = np.where(np.isfinite(passes), passes, least)
        held = np.where(victims.blind, before[:, 0], np.minimum(before[:, 0], state.hidden_m[rows]))
        state.hidden_m[rows] = np.where(seen & ~free, judged, state.hidden_m[rows])
        # A fix that nothing scores may lie beside every lane.
        loose = np.where(free[:, np.newaxis] & ~scored, tried, -np.inf).max(axis=1)
        chosen: Floats = np.where(seen, np.maximum(judged, loose), np.where(free, furthest, held))
        return chosen

    def _by_alarms(self, victims: Victims, state: AdaptiveState, direction: Floats, free: Flags) -> Floats:
        """Return (m,) displacements of an attacker who is told whether there would be an alarm, so many times."""
        rows = victims.rows
        before, stride = state.moved_m[rows], state.stride_m[rows]
        stride = np.where(stride < 0.0, self.growth_m, stride)
        asks = victims.fix_valid & (state.asked[rows] < self.budget) & (stride >= _SHORTEST_M)
        asks &= free | ~victims.blind
        tried = np.minimum(before + np.where(free, self.junction_growth_m, stride), self.cap_m)
        refused = victims.probe(tried[:, np.newaxis, np.newaxis] * direction[:, np.newaxis, :]).ratio[:, 0] > 1.0
        state.asked[rows] += asks
        state.stride_m[rows] = np.where(asks & refused & ~free, 0.5 * stride, stride)
        return np.where(asks, np.where(refused, _RETREAT * before, tried), before)
