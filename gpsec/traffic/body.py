"""The kinematic single-track body that turns SUMO's front point into a driveable vehicle.

SUMO's angle and speed are not a rigid body's motion: in turns and lane changes the angle is not the course, and dead
reckoning with perfect copies of them ends metres off. So the rear axle follows SUMO's front point without slip.
While the front moves by d with course c, the angle φ = c - yaw decays as tan(φ'/2) = tan(φ/2)·exp(-d/L), which is the
exact solution of dφ/dd = -sin φ / L (the tractrix).
"""

from math import atan, atan2, cos, exp, log, pi, sin, sqrt, tan

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel

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
def advance(
    rows: Ints,
    new_front_m: Floats,
    step_s: float,
    axle_m: Floats,
    fresh: Flags,
    front_m: Floats,
    rear_m: Floats,
    yaw_rad: Floats,
    speed_mps: Floats,
    yaw_rate_rps: Floats,
) -> None:
    """Move the bodies in the vehicle rows `rows` to (n, 2) new front points, one for each of them in order.

    A body that is fresh is placed behind its front along its yaw and keeps its speed. The other arguments are fields of
    `Vehicles`.
    """
    for i in range(len(rows)):
        row = rows[i]
        x = new_front_m[i, 0]
        y = new_front_m[i, 1]
        if fresh[row]:
            fresh[row] = False
            yaw_rate_rps[row] = 0.0
        else:
            dx = x - front_m[row, 0]
            dy = y - front_m[row, 1]
            moved = sqrt(dx * dx + dy * dy)
            turn = 0.0
            way = 0.0
            if moved > 1e-9:
                turn, way = follow(yaw_rad[row], atan2(dy, dx), moved, axle_m[row])
            yaw_rad[row] = wrap_angle(yaw_rad[row] + turn)
            speed_mps[row] = way / step_s
            yaw_rate_rps[row] = turn / step_s
        front_m[row, 0] = x
        front_m[row, 1] = y
        rear_m[row, 0] = x - axle_m[row] * cos(yaw_rad[row])
        rear_m[row, 1] = y - axle_m[row] * sin(yaw_rad[row])
