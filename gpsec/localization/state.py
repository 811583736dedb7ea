"""State of every defence's filter."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.fleet import Rows

# Filter state: east, north, yaw, and the slow GNSS error in east and north.
STATES = 5


@dataclass
class FilterState(Rows):
    """Filters of D defences over M track rows.

    Attributes:
        started: (M,) the first fix has come.
        fix_age_s: (M,) time since the last fix.
        mean: (M, D, 5) east and north of the rear axle (m), yaw (rad), slow GNSS error east and north (m).
        covariance: (M, D, 5, 5).
        isolated: (M, D) GNSS is not used.
        quiet_s: (M, D) time in isolation without an alarm.
        consistent_s: (M, D) time in isolation in which fixes have agreed with the estimate.
        isolated_way_m: (M, D) distance travelled in isolation.
        segment: (M, D) map segment of the estimate at the last camera correction, -1 before.
        innovation: (M, D, 2) normalised innovations of the last GNSS update; their squares sum to its NIS.
        innovation_valid: (M, D) there was a GNSS update in this step.
        repairs: (M, D) times that a covariance had to be made positive definite again.

    """

    started: Flags
    fix_age_s: Floats
    mean: Floats
    covariance: Floats
    isolated: Flags
    quiet_s: Floats
    consistent_s: Floats
    isolated_way_m: Floats
    segment: Ints
    innovation: Floats
    innovation_valid: Flags
    repairs: Ints

    @classmethod
    def empty(cls, capacity: int, defences: int) -> Self:
        """Return `capacity` rows of filters that have not started."""
        cells = (capacity, defences)
        return cls(
            started=np.zeros(capacity, np.bool_),
            fix_age_s=np.zeros(capacity),
            mean=np.zeros((*cells, STATES)),
            covariance=np.zeros((*cells, STATES, STATES)),
            isolated=np.zeros(cells, np.bool_),
            quiet_s=np.zeros(cells),
            consistent_s=np.zeros(cells),
            isolated_way_m=np.zeros(cells),
            segment=np.full(cells, -1, np.int32),
            innovation=np.zeros((*cells, 2)),
            innovation_valid=np.zeros(cells, np.bool_),
            repairs=np.zeros(cells, np.int32),
        )
