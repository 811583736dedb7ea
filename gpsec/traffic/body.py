"""The kinematic single-track body that turns SUMO's front point into a driveable vehicle.

SUMO's angle and speed are not a rigid body's motion: in turns and lane changes the angle is not the course, and dead
reckoning with perfect copies of them ends metres off. So the rear axle follows SUMO's front point without slip.
While the front moves by d with course c, the angle φ = c - yaw decays as tan(φ'/2) = tan(φ/2)·exp(-d/L), which is the
exact solution of dφ/dd = -sin φ / L (the tractrix).
"""

from math import atan, atan2, cos, exp, log, pi, sin, sqrt, tan

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.types.vehicles import Vehicles

# Distance of the rear axle from the front bumper as a share of the length: 0.78 fits a 4.6 m car (front overhang
# 0.9 m, wheelbase 2.7 m). Long vehicles are bounded by a 12 m city bus (overhang 2.7 m, wheelbase 5.9 m).
AXLE_SHARE = 0.78
MAX_AXLE_M = 8.6


def axle_distance(length_m: float) -> float:
    """Return the distance from the front bumper back to the rear axle of a body of that length."""
    return min(AXLE_SHARE * length_m, MAX_AXLE_M)


@inline
def follow(yaw_rad: float, course_rad: float, moved_m: float, axle_m: float) -> tuple[float, float]:
    """Return the turn of the body and the way of its rear axle while its front moves straight ahead.

    The way is ∫cos φ dd = d + L·ln((1 + t'²)/(1 + t²)) with t = tan(φ/2); negative where the front is pushed back.
    """
    phi = wrap_angle(course_rad - yaw_rad)
    if phi <= -pi + 1e-9:
        return 0.0, -moved_m
    t = tan(0.5 * phi)
    t_after = t * exp(-moved_m / axle_m)
    turn = phi - 2.0 * atan(t_after)
    way = moved_m + axle_m * log((1.0 + t_after * t_after) / (1.0 + t * t))
    return turn, way


@kernel
def advance(rows: Ints, front_m: Floats, step_s: float, vehicles: Vehicles) -> None:
    """Move the bodies in the (n,) vehicle rows `rows` to the (n, 2) front points `front_m`.

    A body that is fresh is placed behind its front along its yaw and keeps its speed.
    """
    for i in range(len(rows)):
        row = rows[i]
        x = front_m[i, 0]
        y = front_m[i, 1]
        axle_m = vehicles.axle_m[row]
        if vehicles.fresh[row]:
            vehicles.fresh[row] = False
            vehicles.yaw_rate_rps[row] = 0.0
        else:
            dx = x - vehicles.front_m[row, 0]
            dy = y - vehicles.front_m[row, 1]
            moved = sqrt(dx * dx + dy * dy)
            turn = 0.0
            way = 0.0
            if moved > 1e-9:
                turn, way = follow(vehicles.yaw_rad[row], atan2(dy, dx), moved, axle_m)
            vehicles.yaw_rad[row] = wrap_angle(vehicles.yaw_rad[row] + turn)
            vehicles.speed_mps[row] = way / step_s
            vehicles.yaw_rate_rps[row] = turn / step_s
        vehicles.front_m[row, 0] = x
        vehicles.front_m[row, 1] = y
        vehicles.rear_m[row, 0] = x - axle_m * cos(vehicles.yaw_rad[row])
        vehicles.rear_m[row, 1] = y - axle_m * sin(vehicles.yaw_rad[row])
