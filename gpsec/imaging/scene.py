"""What a camera sees of the traffic in one moment."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats


@dataclass(frozen=True)
class SeenBodies:
    """Other vehicles about a camera's own; n of them.

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


def in_frame_of(moment: Moment, points_m: Floats) -> Floats:
    """Return points (n, 2) of the net's frame in the frame of the vehicle: forward and left of its rear axle."""
    c, s = np.cos(moment.yaw_rad), np.sin(moment.yaw_rad)
    away = points_m - moment.rear_m
    return np.stack([away @ np.array([c, s]), away @ np.array([-s, c])], axis=1)
