"""Traffic that was recorded once and is replayed, to the last bit, without SUMO."""

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.traffic.source import Departure, Frame, TrafficSource, step_count

NameColumn = NDArray[np.str_]


@dataclass(frozen=True)
class Recording:
    """Everything a source of traffic gave in F frames, as arrays.

    Frame f has the rows ``rows[start[f]:start[f + 1]]``, and in the same way what was left and who departed.

    Attributes:
        step_s: (1,) length of a step.
        step: (F,) number of each frame's step.
        time_s: (F,) simulated time after it.
        on_road: (F,) vehicles in the simulation, equipped or not.
        start, left_start, departure_start: (F + 1,) where each frame begins in what follows.
        rows, front_m, lane: (V,), (V, 2), (V,) one a vehicle and frame, as in `Frame`.
        left: (L,) rows.
        departure_row: (D,) one a departure from here on, as in `Departure`.
        vehicle_id, sumo_id, vehicle_type, vehicle_class: (D,) fixed-width strings.
        length_m, width_m, yaw_rad, speed_mps: (D,).
        equipped_share: (D,) 0 where the type has none.
        has_equipped_share: (D,).
        sensors: (D,) empty where the type has none.
        spoofer_start: (F + 1,) as `start`, for the vehicles that carry a spoofer.
        spoofer_plan, spoofer_m: (S,), (S, 2) one a carrier and frame: name of its plan, and where it is.
    """

    step_s: Floats
    step: Ints
    time_s: Floats
    on_road: Ints
    start: Longs
    left_start: Longs
    departure_start: Longs
    rows: Ints
    front_m: Floats
    lane: Ints
    left: Ints
    departure_row: Ints
    vehicle_id: NameColumn
    sumo_id: NameColumn
    vehicle_type: NameColumn
    vehicle_class: NameColumn
    length_m: Floats
    width_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    equipped_share: Floats
    has_equipped_share: Flags
    sensors: NameColumn
    spoofer_start: Longs
    spoofer_plan: NameColumn
    spoofer_m: Floats

    def __len__(self) -> int:
        return len(self.step)

    def frame(self, number: int) -> Frame:
        """Return frame `number`, with arrays of its own."""
        of = slice(self.start[number], self.start[number + 1])
        left = slice(self.left_start[number], self.left_start[number + 1])
        entered = range(self.departure_start[number], self.departure_start[number + 1])
        return Frame(
            step=int(self.step[number]),
            time_s=float(self.time_s[number]),
            left=self.left[left].tolist(),
            departures=[self._departure(at) for at in entered],
            rows=self.rows[of].copy(),
            front_m=self.front_m[of].copy(),
            lane=self.lane[of].copy(),
            on_road=int(self.on_road[number]),
            spoofers_m=self._spoofers_m(slice(self.spoofer_start[number], self.spoofer_start[number + 1])),
        )

    def _spoofers_m(self, of: slice) -> dict[str, Floats]:
        plans = self.spoofer_plan[of]
        return {str(plan): self.spoofer_m[of][plans == plan] for plan in dict.fromkeys(plans.tolist())}

    def _departure(self, at: int) -> Departure:
        return Departure(
            row=int(self.departure_row[at]),
            vehicle_id=str(self.vehicle_id[at]),
            sumo_id=str(self.sumo_id[at]),
            vehicle_type=str(self.vehicle_type[at]),
            vehicle_class=str(self.vehicle_class[at]),
            length_m=float(self.length_m[at]),
            width_m=float(self.width_m[at]),
            yaw_rad=float(self.yaw_rad[at]),
            speed_mps=float(self.speed_mps[at]),
            equipped_share=float(self.equipped_share[at]) if self.has_equipped_share[at] else None,
            sensors=str(self.sensors[at]) or None,
        )


def record_traffic(source: TrafficSource, duration_s: float | None) -> Recording:
    """Run `source` to its end or for `duration_s` and return all it gave; the source stays open."""
    frames = list(source.frames(duration_s))
    entered = [departure for frame in frames for departure in frame.departures]
    carriers = [[(plan, at) for plan, at_m in frame.spoofers_m.items() for at in at_m] for frame in frames]

    def of_vehicles(name: str, blank: NDArray[Any]) -> Any:
        return np.concatenate([blank, *(getattr(frame, name) for frame in frames)])

    def of_departures(name: str, kind: type) -> Any:
        return np.array([getattr(departure, name) for departure in entered], kind)

    return Recording(
        step_s=np.array([source.step_s]),
        step=np.array([frame.step for frame in frames], np.int32),
        time_s=np.array([frame.time_s for frame in frames], np.float64),
        on_road=np.array([frame.on_road for frame in frames], np.int32),
        start=_starts([len(frame.rows) for frame in frames]),
        left_start=_starts([len(frame.left) for frame in frames]),
        departure_start=_starts([len(frame.departures) for frame in frames]),
        rows=of_vehicles("rows", np.zeros(0, np.int32)),
        front_m=of_vehicles("front_m", np.zeros((0, 2))),
        lane=of_vehicles("lane", np.zeros(0, np.int32)),
        left=np.array([row for frame in frames for row in frame.left], np.int32),
        departure_row=of_departures("row", np.int32),
        vehicle_id=of_departures("vehicle_id", np.str_),
        sumo_id=of_departures("sumo_id", np.str_),
        vehicle_type=of_departures("vehicle_type", np.str_),
        vehicle_class=of_departures("vehicle_class", np.str_),
        length_m=of_departures("length_m", np.float64),
        width_m=of_departures("width_m", np.float64),
        yaw_rad=of_departures("yaw_rad", np.float64),
        speed_mps=of_departures("speed_mps", np.float64),
        equipped_share=np.array([departure.equipped_share or 0.0 for departure in entered], np.float64),
        has_equipped_share=np.array([departure.equipped_share is not None for departure in entered], np.bool_),
        sensors=np.array([departure.sensors or "" for departure in entered], np.str_),
        spoofer_start=_starts([len(those) for those in carriers]),
        spoofer_plan=np.array([plan for those in carriers for plan, _ in those], np.str_),
        spoofer_m=np.array([at for those in carriers for _, at in those], np.float64).reshape(-1, 2),
    )


def _starts(counts: list[int]) -> Longs:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


class RecordedTraffic:
    """Replays a recording; implements `gpsec.traffic.source.TrafficSource`.

    Attributes:
        step_s: length of a step.
        sumo_s: 0, there is no simulation.
        read_s: wall-clock seconds spent in making frames so far.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.step_s = float(recording.step_s[0])
        self.sumo_s = 0.0
        self.read_s = 0.0

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the recorded frames from the first, to the last or for `duration_s`."""
        count = len(self.recording)
        if duration_s is not None:
            count = min(count, step_count(duration_s, self.step_s))
        for number in range(count):
            before = perf_counter()
            frame = self.recording.frame(number)
            self.read_s += perf_counter() - before
            yield frame

    def close(self) -> None:
        """Do nothing: a recording holds no resources."""
