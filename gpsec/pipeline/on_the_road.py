"""Who is on the road in a step of the closed loop, as bodies, and by numbers that fleet and others share."""

import numpy as np

from gpsec.attacks.base import unit_vectors
from gpsec.core.arrays import Flags, Ints
from gpsec.encounters.encounters import People
from gpsec.encounters.rectangles import Bodies
from gpsec.traffic.commands import Others
from gpsec.types.vehicles import Vehicles


def numbers(rows: Ints, *, others: bool) -> Ints:
    """Return the numbers of vehicle rows, or of others."""
    return (2 * rows + others).astype(np.int32)


def people_of(rows: Ints, vehicles: Vehicles, others: Others, driven: Flags, astray: Flags) -> People:
    """Return the fleet, (n,) `rows`, and after it the others; `driven` and `astray` are (n,) of the fleet."""
    along = unit_vectors(np.concatenate([vehicles.yaw_rad[rows], others.yaw_rad]))
    ux, uy = np.ascontiguousarray(along[:, 0]), np.ascontiguousarray(along[:, 1])
    half_m = 0.5 * np.concatenate([vehicles.length_m[rows], others.length_m])
    front_m = np.concatenate([vehicles.front_m[rows], others.front_m])
    speed = np.concatenate([vehicles.speed_mps[rows], others.speed_mps])
    none = np.zeros(len(others.number), np.bool_)
    return People(
        number=np.concatenate([numbers(rows, others=False), numbers(others.number, others=True)]),
        bodies=Bodies(
            x_m=front_m[:, 0] - half_m * ux,
            y_m=front_m[:, 1] - half_m * uy,
            ux=ux,
            uy=uy,
            half_length_m=half_m,
            half_width_m=0.5 * np.concatenate([vehicles.width_m[rows], others.width_m]),
            vx_mps=speed * ux,
            vy_mps=speed * uy,
        ),
        driven=np.concatenate([driven, none]),
        astray=np.concatenate([astray, none]),
    )
