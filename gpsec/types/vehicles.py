"""Vehicle rows: one belongs to a vehicle from departure to arrival, and holds its truth and its sensors."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Keys
from gpsec.core.tables import blank


@dataclass(frozen=True)
class Identity:
    """Who a vehicle row stands for.

    Attributes:
        vehicle_id: its name in tables.
        vehicle_type: SUMO's.
        profile: index of its sensor profile.
        depart_s: simulated time of departure.
        sumo_id: SUMO's id.

    """

    vehicle_id: str
    vehicle_type: str
    profile: int
    depart_s: float
    sumo_id: str


class Vehicles(NamedTuple):
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
            Then offsets, directions and curvature are those of the vehicle's way, and nothing is scored.
        lane_offset_m: (N,) of the rear axle from the lane's centre, across the lane, left positive.
        lane_yaw_rad: (N,) direction of the lane there.
        lane_width_m: (N,) there.
        followed: (N,) lane that the camera follows, -1 before the first step: that under the rear axle, where SUMO's is
            already the next one. `followed_segment` is the segment of the rear axle on its chain.
        late_steps: (N,) steps since the rear axle left that lane.
        mistaken_steps: (N,) steps for which the camera goes on to show the lane beside it: the left one, where
            negative the right one.
        camera_lane: (N,) lane that the camera shows.
        camera_offset_m, camera_yaw_rad, camera_curvature_per_m: (N,) offset from that lane, its direction, and its
            curvature, left positive.
        marked: (N,) that lane is to be seen: front and rear axle are both on lanes with markings (not inside a
            junction) that lead the vehicle's way, and the lines are not too near for the camera.
    """

    key: Keys = blank(np.uint64(0))
    profile: Ints = blank(0)
    axle_m: Floats = blank(3.5)
    length_m: Floats = blank(4.5)
    width_m: Floats = blank(1.8)
    born_step: Ints = blank(0)
    fresh: Flags = blank(True)
    front_m: Floats = blank(0.0, 2)
    rear_m: Floats = blank(0.0, 2)
    yaw_rad: Floats = blank(0.0)
    speed_mps: Floats = blank(0.0)
    yaw_rate_rps: Floats = blank(0.0)
    lane: Ints = blank(-1)
    segment: Ints = blank(-1)
    against: Flags = blank(False)
    lane_offset_m: Floats = blank(0.0)
    lane_yaw_rad: Floats = blank(0.0)
    lane_width_m: Floats = blank(0.0)
    followed: Ints = blank(-1)
    followed_segment: Ints = blank(-1)
    late_steps: Ints = blank(0)
    mistaken_steps: Ints = blank(0)
    camera_lane: Ints = blank(-1)
    camera_offset_m: Floats = blank(0.0)
    camera_yaw_rad: Floats = blank(0.0)
    camera_curvature_per_m: Floats = blank(0.0)
    marked: Flags = blank(False)


class Measurements(NamedTuple):
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

    fix_m: Floats = blank(0.0, 2)
    fix_valid: Flags = blank(False)
    speed_mps: Floats = blank(0.0)
    yaw_rate_rps: Floats = blank(0.0)
    heading_rad: Floats = blank(0.0)
    lane_poly: Floats = blank(0.0, 4)
    camera_valid: Flags = blank(False)
    camera_sigma_m: Floats = blank(0.0)
