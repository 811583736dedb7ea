"""What the sensors of a vehicle remember from step to step."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from gpsec.arrays import Flags, Floats
from gpsec.fleet import Rows

# Columns of `SensorState.out`.
GNSS, GYRO, ODOMETER, HEADING, CAMERA = range(5)
# Columns of `SensorState.slip`.
EAST, NORTH, FORWARD, LEFT, TURN = range(5)
# Columns of `SensorState.motion`.
SPEED, YAW_RATE = range(2)


@dataclass
class SensorState(Rows):
    """N vehicle rows.

    Attributes:
        started: (N,) a step has been sensed since the vehicle entered.
        gnss_bias_m: (N, 2) east and north.
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

    started: Flags
    gnss_bias_m: Floats
    gyro_bias_rps: Floats
    heading_bias_rad: Floats
    camera_bias_m: Floats
    odometer_scale: Floats
    mount_m: Floats
    out: Flags
    speed_mps: Floats
    yaw_rate_rps: Floats
    heading_rad: Floats
    true_yaw_rad: Floats
    true_rear_m: Floats
    motion: Floats
    slip: Floats

    @classmethod
    def empty(cls, capacity: int, slip_steps: int, motion_steps: int) -> Self:
        """Return `capacity` rows that no vehicle owns, whose rings hold so many steps."""
        n = capacity
        return cls(
            started=np.zeros(n, np.bool_),
            gnss_bias_m=np.zeros((n, 2)),
            gyro_bias_rps=np.zeros(n),
            heading_bias_rad=np.zeros(n),
            camera_bias_m=np.zeros(n),
            odometer_scale=np.zeros(n),
            mount_m=np.zeros(n),
            out=np.zeros((n, 5), np.bool_),
            speed_mps=np.zeros(n),
            yaw_rate_rps=np.zeros(n),
            heading_rad=np.zeros(n),
            true_yaw_rad=np.zeros(n),
            true_rear_m=np.zeros((n, 2)),
            motion=np.zeros((n, motion_steps, 2)),
            slip=np.zeros((n, slip_steps, 5)),
        )
