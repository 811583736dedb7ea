"""What the filters know of the sensors: figures of the profile, never tuned against a score."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats

# An error that lasts (odometer scale, heading) is not white; over the seconds that a filter remembers, it acts like
# noise of this correlation time.
LASTING_ERROR_S = 1.0


@dataclass(frozen=True)
class FilterNoise:
    """Sensor figures of one profile, as its data sheet states them.

    Attributes:
        gnss_white_m: standard deviation of the white part, per axis.
        gnss_bias_m, gnss_bias_tau_s: standard deviation and correlation time of the slow part, per axis.
        gnss_period_s: time between fixes.
        odometer_white_mps, gyro_white_rps: standard deviation of speed and yaw rate over a step that, independent from
            step to step, adds up to the error of way and angle; where a sample is held for n steps, √n times its own.
        odometer_scale: of the relative scale error; gyro_bias_rps: of the gyro's bias.
        heading_rad: standard deviation of the heading with which a filter starts.
        residual_m: standard deviation of camera offset minus map offset of an honest fix.
        gyro_bias_tau_s: correlation time of the gyro's bias.
        camera_white_m: standard deviation of the white part of C0 where the whole range is in view.
        camera_slope: of C1, likewise.
        camera_bias_m, camera_bias_tau_s: of the slow part of C0, and its correlation time.
        camera_mount_m: of the mounting offset, constant for a vehicle.

    """

    gnss_white_m: float
    gnss_bias_m: float
    gnss_bias_tau_s: float
    gnss_period_s: float
    odometer_white_mps: float
    odometer_scale: float
    gyro_white_rps: float
    gyro_bias_rps: float
    heading_rad: float
    residual_m: float
    gyro_bias_tau_s: float
    camera_white_m: float
    camera_slope: float
    camera_bias_m: float
    camera_bias_tau_s: float
    camera_mount_m: float


class NoiseTable(NamedTuple):
    """The same figures for Q profiles, as (Q,) arrays that kernels read."""

    gnss_white_m: Floats
    gnss_bias_m: Floats
    gnss_bias_tau_s: Floats
    gnss_period_s: Floats
    odometer_white_mps: Floats
    odometer_scale: Floats
    gyro_white_rps: Floats
    gyro_bias_rps: Floats
    heading_rad: Floats
    residual_m: Floats
    gyro_bias_tau_s: Floats
    camera_white_m: Floats
    camera_slope: Floats
    camera_bias_m: Floats
    camera_bias_tau_s: Floats
    camera_mount_m: Floats


def noise_table(profiles: list[FilterNoise]) -> NoiseTable:
    """Return the figures of the run's profiles, in their order."""
    return NoiseTable(*(np.array([getattr(profile, name) for profile in profiles]) for name in NoiseTable._fields))
