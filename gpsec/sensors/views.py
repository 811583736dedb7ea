"""Arrays that the sensor kernels read and write, named as in the structures that they come from."""

from typing import NamedTuple

from gpsec.arrays import Flags, Floats, Ints, Keys


class Truth(NamedTuple):
    """The part of `fleet.Vehicles` that sensors measure; N vehicle rows."""

    key: Keys
    profile: Ints
    rear_m: Floats
    yaw_rad: Floats
    speed_mps: Floats
    yaw_rate_rps: Floats
    lane_offset_m: Floats
    lane_yaw_rad: Floats
    curvature_per_m: Floats
    marked: Flags


class Memory(NamedTuple):
    """The arrays of `SensorState`; N vehicle rows."""

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


class Samples(NamedTuple):
    """The arrays of `fleet.Measurements`; N vehicle rows."""

    fix_m: Floats
    fix_valid: Flags
    speed_mps: Floats
    yaw_rate_rps: Floats
    heading_rad: Floats
    lane_poly: Floats
    camera_valid: Flags
    camera_sigma_m: Floats
