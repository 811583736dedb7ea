"""What the sensors of a vehicle remember from step to step."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats
from gpsec.core.tables import blank

# Columns of `SensorState.out`.
GNSS, GYRO, ODOMETER, HEADING, CAMERA = range(5)
# Columns of `SensorState.slip`.
EAST, NORTH, FORWARD, LEFT, TURN = range(5)
# Columns of `SensorState.motion`.
SPEED, YAW_RATE = range(2)


class SensorState(NamedTuple):
    """N vehicle rows.

    Attributes:
        started: (N,) a step has been sensed since the vehicle entered.
        gnss_bias_m: (N, 2) east and north.
        wander_mps, wander_m: (N, 2) rate of the smooth wander of fixes, and where it has led to.
        wrong_line: (N,) side of the wrong line that the camera shows: 1 left, -1 right, 0 for none.
        gyro_bias_rps, heading_bias_rad, camera_bias_m: (N,) Gauss-Markov biases.
        odometer_scale: (N,) constant of the journey, as a ratio.
        mount_m: (N,) offset of the camera, constant of the vehicle.
        out: (N, 5) an outage lasts; columns GNSS, GYRO, ODOMETER, HEADING, CAMERA.
        speed_mps, yaw_rate_rps, heading_rad: (N,) last values given, held between samples.
        true_yaw_rad: (N,) truth of the step before.
        true_rear_m: (N, 2) truth of the step before.
        motion: (N, R, 2) ring over the last R steps of true SPEED (m/s) and YAW_RATE (rad/s); before its first step a
            vehicle moved as in that.
        slip: (N, S, 5) ring over the last S steps of measured minus true motion in a step: EAST and NORTH in
            the net's frame; FORWARD, LEFT and TURN (rad) in the vehicle's frame at the step's end.
    """

    started: Flags = blank(False)
    gnss_bias_m: Floats = blank(0.0, 2)
    wander_mps: Floats = blank(0.0, 2)
    wander_m: Floats = blank(0.0, 2)
    wrong_line: Floats = blank(0.0)
    gyro_bias_rps: Floats = blank(0.0)
    heading_bias_rad: Floats = blank(0.0)
    camera_bias_m: Floats = blank(0.0)
    odometer_scale: Floats = blank(0.0)
    mount_m: Floats = blank(0.0)
    out: Flags = blank(False, 5)
    speed_mps: Floats = blank(0.0)
    yaw_rate_rps: Floats = blank(0.0)
    heading_rad: Floats = blank(0.0)
    true_yaw_rad: Floats = blank(0.0)
    true_rear_m: Floats = blank(0.0, 2)
    motion: Floats = blank(0.0, "motion_steps", 2)
    slip: Floats = blank(0.0, "slip_steps", 5)
