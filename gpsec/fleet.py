"""The arrays that flow through the loop, and the rows that vehicles own in them.

Two kinds of row exist. A **vehicle row** belongs to one vehicle on the road, from departure to arrival, and holds its
truth and its sensors. A **track row** belongs to one vehicle under one attack plan and holds everything that
depends on the spoofed fix: residual, detectors, filters, outcomes. Every vehicle has a track under plan 0 (no attack);
its track under another plan is forked from that one at the moment its attack begins, because until then the two
are equal to the last bit.
"""

from dataclasses import dataclass, fields
from heapq import heappop, heappush
from typing import Self

import numpy as np

from gpsec.arrays import Flags, Floats, Ints, Keys

# A residual stands for a tenth of a second, whatever the step: detectors score at most so often, and learned so.
SAMPLE_S = 0.1


class Rows:
    """Base of every structure of arrays: a dataclass whose fields are arrays with the row as first axis.

    A subclass is created with its initial values in every row; a row that is reset gets those of row 0 at creation.
    """

    def __post_init__(self) -> None:
        self._names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        self._blank = {name: array[:1].copy() for name, array in self._arrays()}

    def _arrays(self) -> list[tuple[str, np.ndarray]]:
        return [(name, getattr(self, name)) for name in self._names]

    @property
    def capacity(self) -> int:
        """Number of rows that there is room for."""
        return len(self._arrays()[0][1])

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` rows; the new ones hold initial values."""
        for name, array in self._arrays():
            rows = len(array)
            if rows >= capacity:
                continue
            # Zeros take no memory until something is written to them.
            grown = np.zeros((capacity, *array.shape[1:]), array.dtype)
            grown[:rows] = array
            if self._blank[name].any():
                grown[rows:] = self._blank[name]
            setattr(self, name, grown)

    def reset(self, rows: Ints) -> None:
        """Give `rows` their initial values again."""
        for name, array in self._arrays():
            array[rows] = self._blank[name]

    def copy(self, source: Ints, target: Ints) -> None:
        """Copy the rows `source` onto the rows `target`, pair by pair."""
        for _, array in self._arrays():
            array[target] = array[source]


class Slots:
    """Hands out row numbers, always the lowest that is free."""

    def __init__(self) -> None:
        self._free: list[int] = []
        self.used = 0

    def take(self) -> int:
        """Return a free row."""
        if self._free:
            return heappop(self._free)
        self.used += 1
        return self.used - 1

    def give_back(self, row: int) -> None:
        """Make `row` free again; it must be in use."""
        heappush(self._free, row)


@dataclass
class Vehicles(Rows):
    """Truth of the vehicles on the road; N vehicle rows.

    Attributes:
        key: (N,) identity for counter-based noise, from run seed and vehicle id.
        profile: (N,) index of the sensor profile among those of the run.
        axle_m: (N,) distance from the front bumper back to the rear axle.
        length_m, width_m: (N,) of the body.
        born_step: (N,) step of departure.
        fresh: (N,) no step has been taken since departure.
        front_m: (N, 2) centre of the front bumper in the net's frame (SUMO's position).
        rear_m: (N, 2) centre of the rear axle: the reference point of truth, estimate and map offset.
        yaw_rad: (N,) of the body, counter-clockwise from east.
        speed_mps, yaw_rate_rps: (N,) mean of the rear axle over the last step.
        lane: (N,) index of the lane of the front, as SUMO says.
        segment: (N,) map segment of the rear axle on the true geometry, -1 before the first match.
        against: (N,) that lane leads the other way: the vehicle overtakes on an oncoming lane, or is turning round.
            Then offset, direction and curvature are those of the vehicle's way, and nothing is scored.
        lane_offset_m: (N,) of the rear axle from the lane's centre, across the lane, left positive.
        lane_yaw_rad: (N,) direction of the lane there.
        curvature_per_m: (N,) of the lane there, left positive.
        lane_width_m: (N,) there.
        marked: (N,) front and rear axle are both on lanes with markings (not inside a junction) that lead the vehicle's
            way.
    """

    key: Keys
    profile: Ints
    axle_m: Floats
    length_m: Floats
    width_m: Floats
    born_step: Ints
    fresh: Flags
    front_m: Floats
    rear_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    yaw_rate_rps: Floats
    lane: Ints
    segment: Ints
    against: Flags
    lane_offset_m: Floats
    lane_yaw_rad: Floats
    curvature_per_m: Floats
    lane_width_m: Floats
    marked: Flags

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that no vehicle owns."""
        n = capacity
        return cls(
            key=np.zeros(n, np.uint64),
            profile=np.zeros(n, np.int32),
            axle_m=np.full(n, 3.5),
            length_m=np.full(n, 4.5),
            width_m=np.full(n, 1.8),
            born_step=np.zeros(n, np.int32),
            fresh=np.ones(n, np.bool_),
            front_m=np.zeros((n, 2)),
            rear_m=np.zeros((n, 2)),
            yaw_rad=np.zeros(n),
            speed_mps=np.zeros(n),
            yaw_rate_rps=np.zeros(n),
            lane=np.full(n, -1, np.int32),
            segment=np.full(n, -1, np.int32),
            against=np.zeros(n, np.bool_),
            lane_offset_m=np.zeros(n),
            lane_yaw_rad=np.zeros(n),
            curvature_per_m=np.zeros(n),
            lane_width_m=np.zeros(n),
            marked=np.zeros(n, np.bool_),
        )


@dataclass
class Measurements(Rows):
    """What the sensors of a vehicle give in this step, before any attack; N vehicle rows.

    Attributes:
        fix_m: (N, 2) GNSS position of the rear axle in the net's frame, aligned to now.
        fix_valid: (N,) a fix arrived in this step.
        speed_mps: (N,) odometer, over the last step.
        yaw_rate_rps: (N,) gyro, over the last step.
        heading_rad: (N,) yaw as the vehicle knows it (dual antenna or INS).
        lane_poly: (N, 4) camera's C0 … C3 (Eq 1): lane centre y = C0 + C1 x + C2 x² + C3 x³ in the vehicle frame.
        camera_valid: (N,) the camera saw the lane in this step.
        camera_sigma_m: (N,) standard deviation that the camera states for C0.
    """

    fix_m: Floats
    fix_valid: Flags
    speed_mps: Floats
    yaw_rate_rps: Floats
    heading_rad: Floats
    lane_poly: Floats
    camera_valid: Flags
    camera_sigma_m: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows without a measurement."""
        n = capacity
        return cls(
            fix_m=np.zeros((n, 2)),
            fix_valid=np.zeros(n, np.bool_),
            speed_mps=np.zeros(n),
            yaw_rate_rps=np.zeros(n),
            heading_rad=np.zeros(n),
            lane_poly=np.zeros((n, 4)),
            camera_valid=np.zeros(n, np.bool_),
            camera_sigma_m=np.zeros(n),
        )


@dataclass
class Tracks(Rows):
    """One vehicle under one attack plan; M track rows.

    Attributes:
        vehicle: (M,) vehicle row.
        plan: (M,) index of the plan; 0 is *no attack*.
        settled: (M,) the vehicle has been on the road long enough to be scored.
        attacked: (M,) the attack is active in this step (also where it denies the fix).
        start_step: (M,) step in which the attack began, -1 under plan 0.
        end_step: (M,) first step after the attack, -1 while it is not over and under plan 0.
        fix_m: (M, 2) GNSS position after the attack.
        fix_valid: (M,) there is one in this step.
        deviation_m: (M,) cross-track error of the undefended estimate after the last step, kept while attacked.
        segment: (M,) map segment (of the vehicle's map) that the fix was matched to, -1 before.
        residual_m: (M,) camera offset minus map-matched offset of the paired fix; 0 where not valid.
        residual_valid: (M,) a residual was formed in this step.
        paired_m: (M, 2) the fix that it was formed of, carried on to now by odometer, gyro and heading.
    """

    vehicle: Ints
    plan: Ints
    settled: Flags
    attacked: Flags
    start_step: Ints
    end_step: Ints
    fix_m: Floats
    fix_valid: Flags
    deviation_m: Floats
    segment: Ints
    residual_m: Floats
    residual_valid: Flags
    paired_m: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that no track owns."""
        n = capacity
        return cls(
            vehicle=np.full(n, -1, np.int32),
            plan=np.zeros(n, np.int32),
            settled=np.zeros(n, np.bool_),
            attacked=np.zeros(n, np.bool_),
            start_step=np.full(n, -1, np.int32),
            end_step=np.full(n, -1, np.int32),
            fix_m=np.zeros((n, 2)),
            fix_valid=np.zeros(n, np.bool_),
            deviation_m=np.zeros(n),
            segment=np.full(n, -1, np.int32),
            residual_m=np.zeros(n),
            residual_valid=np.zeros(n, np.bool_),
            paired_m=np.zeros((n, 2)),
        )
