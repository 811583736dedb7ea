"""What an attacker sees of the victim: how far it has been led off."""

from math import cos, sin

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel


@kernel
def note_deviation(
    rows: Ints,
    attacked: Flags,
    vehicle: Ints,
    estimate_m: Floats,
    rear_m: Floats,
    lane_yaw_rad: Floats,
    deviation_m: Floats,
) -> None:
    """Set the cross-track error of the undefended estimate, defence 0 of (M, D, 2), for track rows under attack.

    The attacker is taken to know it. Other arguments are fields of `Tracks` and `Vehicles`.
    """
    for row in rows:
        if attacked[row]:
            v = vehicle[row]
            x = estimate_m[row, 0, 0] - rear_m[v, 0]
            y = estimate_m[row, 0, 1] - rear_m[v, 1]
            deviation_m[row] = cos(lane_yaw_rad[v]) * y - sin(lane_yaw_rad[v]) * x
