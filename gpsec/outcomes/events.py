"""Tracks that are over: who drove, what was planned, and the sums of the whole life."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, concatenated, taken
from gpsec.outcomes.state import ATTACK, OutcomeState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity


@dataclass(frozen=True)
class ClosedTracks:
    """T tracks that are over.

    Attributes:
        vehicle_id, vehicle_type: (T,) texts.
        profile, plan: (T,) indices.
        depart_s: (T,) time of departure.
        arrive_s: (T,) time of arrival where `arrived`, otherwise 0.
        arrived: (T,) the vehicle left before the run ended.
        start_step, end_step: (T,) of the attack, as in `Tracks`.
        state: the sums; T rows.

    """

    vehicle_id: NDArray[np.str_]
    vehicle_type: NDArray[np.str_]
    profile: Ints
    plan: Ints
    depart_s: Floats
    arrive_s: Floats
    arrived: Flags
    start_step: Ints
    end_step: Ints
    state: OutcomeState

    def __len__(self) -> int:
        return len(self.plan)

    @classmethod
    def none(cls, detectors: int, defences: int) -> Self:
        """Return no track at all."""
        sums = Table(OutcomeState, 0, detectors=detectors, defences=defences).now
        return cls.at(np.zeros(0, np.int32), Table(Tracks, 0).now, sums, [], None)

    @classmethod
    def at(
        cls, rows: Ints, tracks: Tracks, state: OutcomeState, people: Sequence[Identity], ended_s: float | None
    ) -> Self:
        """Return copies of the track rows `rows` of `people` (one a row), who left at `ended_s`, None where not."""
        return cls(
            vehicle_id=np.array([who.vehicle_id for who in people], np.str_),
            vehicle_type=np.array([who.vehicle_type for who in people], np.str_),
            profile=np.array([who.profile for who in people], np.int32),
            plan=tracks.plan[rows],
            depart_s=np.array([who.depart_s for who in people], np.float64),
            arrive_s=np.full(len(people), ended_s or 0.0),
            arrived=np.full(len(people), ended_s is not None),
            start_step=tracks.start_step[rows],
            end_step=tracks.end_step[rows],
            state=taken(state, rows),
        )

    @classmethod
    def concatenate(cls, parts: list[Self]) -> Self:
        """Return the tracks of one or more `parts`, ordered by vehicle and plan, whatever their order was."""
        whole = cls(
            **{
                name: np.concatenate([getattr(part, name) for part in parts])
                for name in cls.__dataclass_fields__
                if name != "state"
            },
            state=concatenated([part.state for part in parts]),
        )
        return whole.take(np.lexsort((whole.plan, whole.vehicle_id)).astype(np.int32))

    def take(self, rows: Ints | Flags) -> Self:
        """Return copies of some tracks (numbers, or one flag a track)."""
        return type(self)(
            **{name: getattr(self, name)[rows] for name in self.__dataclass_fields__ if name != "state"},
            state=taken(self.state, rows),
        )

    def events(self) -> Self:
        """Return the tracks under an attack that has begun."""
        return self.take((self.plan > 0) & self.state.in_event)

    def of_plan(self, plan: int) -> Self:
        """Return the tracks of one plan that were scored: settled without an attack, attacked with one."""
        scored = self.state.in_event if plan > 0 else self.state.steps[:, 0] > 0
        return self.take((self.plan == plan) & scored)

    def last_step(self) -> Ints:
        """Return (T,) first steps after the attack, also where the vehicle left before it was over."""
        cut = self.start_step + self.state.steps[:, ATTACK] + self.state.left_out
        return np.where(self.end_step >= 0, self.end_step, cut).astype(np.int32)
