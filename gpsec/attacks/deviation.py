"""What an attacker sees of the victim: how far it has been led off."""

from math import cos, sin

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles


@kernel
def note_deviation(rows: Ints, tracks: Tracks, vehicles: Vehicles, estimate_m: Floats) -> None:
    """Set the cross-track error of the undefended estimate, defence 0 of (M, D, 2), for track rows under attack.

    The attacker is taken to know it.
    """
    for row in rows:
        if tracks.attacked[row]:
            v = tracks.vehicle[row]
            yaw = vehicles.lane_yaw_rad[v]
            x = estimate_m[row, 0, 0] - vehicles.rear_m[v, 0]
            y = estimate_m[row, 0, 1] - vehicles.rear_m[v, 1]
            tracks.deviation_m[row] = cos(yaw) * y - sin(yaw) * x
