"""What a camera sees of the traffic in one moment."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.tables import taken

# Who is further away is in no picture.
_IN_SIGHT_M = 110.0


class SeenBodies(NamedTuple):
    """Vehicles on the road; n of them.

    Attributes:
        rear_m: (n, 2) rear axles in the net's frame.
        yaw_rad, axle_m, length_m, width_m: (n,) as of `gpsec.types.vehicles.Vehicles`.
        key: (n,) identities, which give them height and colour.
    """

    rear_m: Floats
    yaw_rad: Floats
    axle_m: Floats
    length_m: Floats
    width_m: Floats
    key: np.ndarray


@dataclass(frozen=True)
class Moment:
    """One moment of one vehicle.

    Attributes:
        step: number of the picture, which makes its noise.
        rear_m: (2,) rear axle in the net's frame.
        yaw_rad: of the body.
        others: vehicles about it, itself not among them.
    """

    step: int
    rear_m: Floats
    yaw_rad: float
    others: SeenBodies


def moment_of(step: int, bodies: SeenBodies, own: int) -> Moment:
    """Return what the camera of one of the `bodies`, the one at the place `own`, has around it."""
    near = np.abs(bodies.rear_m - bodies.rear_m[own]).max(axis=1) < _IN_SIGHT_M
    near[own] = False
    others = taken(bodies, np.flatnonzero(near).astype(np.int32))
    return Moment(step, bodies.rear_m[own], float(bodies.yaw_rad[own]), others)


def in_frame_of(moment: Moment, points_m: Floats) -> Floats:
    """Return points (n, 2) of the net's frame in the frame of the vehicle: forward and left of its rear axle."""
    c, s = np.cos(moment.yaw_rad), np.sin(moment.yaw_rad)
    away = points_m - moment.rear_m
    return np.stack([away @ np.array([c, s]), away @ np.array([-s, c])], axis=1)
