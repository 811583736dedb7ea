"""What the outcomes see of one step."""

from dataclasses import dataclass

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles


@dataclass(frozen=True)
class StepView:
    """The loop's arrays after one step. K detectors, D defences; arrays have a row for every track row of the capacity.

    Attributes:
        step: number of the step; step_s: its length; time_s: simulated time after it.
        rows: (m,) track rows in use.
        tracks, vehicles: the fleet; `tracks.vehicle[row]` is the vehicle row.
        statistic, scored, alarm: (M, K) of the detectors.
        estimate_m: (M, D, 2) estimated rear axle in the net's frame, under each defence.
        isolated: (M, D) the defence is not using GNSS.

    """

    step: int
    step_s: float
    time_s: float
    rows: Ints
    tracks: Tracks
    vehicles: Vehicles
    statistic: Floats
    scored: Flags
    alarm: Flags
    estimate_m: Floats
    isolated: Flags
