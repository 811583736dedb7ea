"""What the outcomes see of one step."""

from dataclasses import dataclass

from gpsec.core.arrays import Ints
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


@dataclass(frozen=True)
class StepView:
    """The loop's arrays after one step. K detectors, D defences; arrays have a row for every track row of the capacity.

    Attributes:
        step: number of the step; step_s: its length; time_s: simulated time after it.
        rows: (m,) track rows in use.
        tracks, vehicles: the fleet; `tracks.vehicle[row]` is the vehicle row.
        seen: what the sensors gave.
        answers: of detectors and defences.

    """

    step: int
    step_s: float
    time_s: float
    rows: Ints
    tracks: Tracks
    vehicles: Vehicles
    seen: Measurements
    answers: Answers
