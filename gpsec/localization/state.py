"""State of every defence's filter.

Defences that have done the same so far are in the same state, to the last bit: the same filter has seen the same
odometry and the same fixes. Such cells of a track **share** one filter, that of their leader, until they part: because
one isolates GNSS and another does not, or with another response, or because they take GNSS back at different times. So
it costs little to try one more detector. Defences whose responses learn, or keep a past, share filters among themselves
only: theirs are different from the first step on.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import Rows

# Filter state: east, north, yaw, and the slow GNSS error in east and north.
STATES = 5


class FilterArrays(NamedTuple):
    """The fields of `FilterState`, as kernels take them."""

    started: Flags
    fix_age_s: Floats
    leader: Ints
    isolated: Flags
    entered: Flags
    quiet_s: Floats
    steps: Ints
    past_column: Ints
    past_mean: Floats
    past_covariance: Floats
    past_isolated: Flags
    mean: Floats
    covariance: Floats
    consistent_s: Floats
    isolated_way_m: Floats
    segment: Ints
    innovation: Floats
    innovation_valid: Flags
    repairs: Ints


@dataclass
class FilterState(Rows):
    """Filters of D defences over M track rows.

    Attributes:
        started: (M,) the first fix has come.
        fix_age_s: (M,) time since the last fix.
        leader: (M, D) defence whose filter this one shares; its own number where it leads.
        isolated: (M, D) GNSS is not used.
        entered: (M, D) isolated since this very step.
        quiet_s: (M, D) time in isolation without an alarm.
        steps: (M,) steps since the first fix.
        past_column: (M, D) where the past of a defence's filter is kept, -1 where it is not.
        past_mean, past_covariance, past_isolated: (M, R, B, …) ring of what a filter was at B times, for those R
            defences that roll back; the covariances by their lower triangles. `gpsec.localization.history`.
        mean: (M, D, S) east and north of the rear axle (m), yaw (rad), slow GNSS error east and north (m). This and
            what follows is meaningful where a defence leads. Where a response of the run learns, there is room for
            two states more, the scale error of the odometer (ratio) and the bias of the gyro (rad/s), which
            `gpsec.localization.learning` uses.
        covariance: (M, D, S, S).
        consistent_s: (M, D) time in isolation in which fixes have agreed with the estimate.
        isolated_way_m: (M, D) distance travelled in isolation.
        segment: (M, D) map segment of the estimate at the last camera correction, -1 before.
        innovation: (M, D, 2) normalised innovations of the last GNSS update; their squares sum to its NIS.
        innovation_valid: (M, D) there was a GNSS update in this step.
        repairs: (M, D) times that a covariance had to be made positive definite again.

    """

    started: Flags
    fix_age_s: Floats
    leader: Ints
    isolated: Flags
    entered: Flags
    quiet_s: Floats
    steps: Ints
    past_column: Ints
    past_mean: Floats
    past_covariance: Floats
    past_isolated: Flags
    mean: Floats
    covariance: Floats
    consistent_s: Floats
    isolated_way_m: Floats
    segment: Ints
    innovation: Floats
    innovation_valid: Flags
    repairs: Ints

    @classmethod
    def empty(
        cls, capacity: int, leader: Sequence[int], states: int = STATES, past_of: Sequence[int] = (), snapshots: int = 0
    ) -> Self:
        """Return `capacity` rows of filters that have not started; `leader` says which defences share one.

        The filters of the defences `past_of` keep what they were at `snapshots` times.
        """
        cells = (capacity, len(leader))
        past = (capacity, len(past_of), snapshots)
        column = np.full(len(leader), -1, np.int32)
        column[list(past_of)] = np.arange(len(past_of))
        return cls(
            started=np.zeros(capacity, np.bool_),
            fix_age_s=np.zeros(capacity),
            leader=np.tile(np.array(leader, np.int32), (capacity, 1)),
            isolated=np.zeros(cells, np.bool_),
            entered=np.zeros(cells, np.bool_),
            quiet_s=np.zeros(cells),
            steps=np.zeros(capacity, np.int32),
            past_column=np.tile(column, (capacity, 1)),
            past_mean=np.zeros((*past, states)),
            past_covariance=np.zeros((*past, states * (states + 1) // 2)),
            past_isolated=np.zeros(past, np.bool_),
            mean=np.zeros((*cells, states)),
            covariance=np.zeros((*cells, states, states)),
            consistent_s=np.zeros(cells),
            isolated_way_m=np.zeros(cells),
            segment=np.full(cells, -1, np.int32),
            innovation=np.zeros((*cells, 2)),
            innovation_valid=np.zeros(cells, np.bool_),
            repairs=np.zeros(cells, np.int32),
        )

    def arrays(self) -> FilterArrays:
        """Return the arrays themselves."""
        return FilterArrays(*(getattr(self, name) for name in FilterArrays._fields))

    def apart(self) -> Self:
        """Return a copy in which every defence has a filter of its own."""
        row = np.arange(self.capacity)[:, np.newaxis]
        defences = self.leader.shape[1]
        shared = set(FilterArrays._fields[FilterArrays._fields.index("mean") :])
        fields = {name: array[row, self.leader] if name in shared else array.copy() for name, array in self._arrays()}
        fields["leader"] = np.broadcast_to(np.arange(defences, dtype=np.int32), self.leader.shape).copy()
        return type(self)(**fields)


@inline
def part(filters: FilterArrays, row: int, key: Ints, before: Ints) -> None:
    """Part the defences of a row that share a filter but differ in (D,) `key`; `before` is (D,) room to work in.

    Those of the leader's key stay with it. Of the others, the first of each key leads and gets a copy of the filter.
    """
    leader = filters.leader[row]
    for d in range(len(key)):
        before[d] = leader[d]
    for d in range(len(key)):
        old = before[d]
        if key[d] == key[old]:
            continue
        new = d
        for other in range(old + 1, d):
            if before[other] == old and key[other] == key[d]:
                new = other
                break
        leader[d] = new
        if new == d:
            _copy(filters, row, old, d)


@inline
def _copy(filters: FilterArrays, row: int, source: int, target: int) -> None:
    states = filters.mean.shape[2]
    for i in range(states):
        filters.mean[row, target, i] = filters.mean[row, source, i]
        for j in range(states):
            filters.covariance[row, target, i, j] = filters.covariance[row, source, i, j]
    filters.consistent_s[row, target] = filters.consistent_s[row, source]
    filters.isolated_way_m[row, target] = filters.isolated_way_m[row, source]
    filters.segment[row, target] = filters.segment[row, source]
    filters.innovation[row, target, 0] = filters.innovation[row, source, 0]
    filters.innovation[row, target, 1] = filters.innovation[row, source, 1]
    filters.innovation_valid[row, target] = filters.innovation_valid[row, source]
    filters.repairs[row, target] = filters.repairs[row, source]
    old = filters.past_column[row, source]
    new = filters.past_column[row, target]
    if old < 0 or new < 0:
        return
    for k in range(filters.past_isolated.shape[2]):
        filters.past_isolated[row, new, k] = filters.past_isolated[row, old, k]
        for i in range(states):
            filters.past_mean[row, new, k, i] = filters.past_mean[row, old, k, i]
        for i in range(filters.past_covariance.shape[3]):
            filters.past_covariance[row, new, k, i] = filters.past_covariance[row, old, k, i]


@kernel
def report(rows: Ints, filters: FilterArrays, estimate_m: Floats, isolated: Flags) -> None:
    """Set the (M, D, 2) estimates of the rear axle and the (M, D) flags of isolation of the track rows `rows`."""
    for row in rows:
        for d in range(filters.leader.shape[1]):
            leader = filters.leader[row, d]
            estimate_m[row, d, 0] = filters.mean[row, leader, 0]
            estimate_m[row, d, 1] = filters.mean[row, leader, 1]
            isolated[row, d] = filters.isolated[row, d]
