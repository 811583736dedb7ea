"""What the filters know of the sensors: figures of the profile, never tuned against a score."""

from typing import Generic, NamedTuple, TypeVar

import numpy as np

from gpsec.core.arrays import Floats

T = TypeVar("T", float, Floats)

# An error that lasts (odometer scale, heading) is not white; over the seconds that a filter remembers, it acts like
# noise of this correlation time.
LASTING_ERROR_S = 1.0


class FilterNoise(NamedTuple, Generic[T]):
    """Sensor figures as data sheets state them: numbers of one profile, or (Q,) arrays of Q profiles.

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
        camera_slope_correlation: of the white parts of C0 and C1.
        camera_bias_m, camera_bias_tau_s: of the slow part of C0, and its correlation time.
        camera_mount_m: of the mounting offset, constant for a vehicle.
        camera_period_s: time between its samples.
        gyro_latency_s: age of the yaw rate when it arrives.
    """

    gnss_white_m: T
    gnss_bias_m: T
    gnss_bias_tau_s: T
    gnss_period_s: T
    odometer_white_mps: T
    odometer_scale: T
    gyro_white_rps: T
    gyro_bias_rps: T
    heading_rad: T
    residual_m: T
    gyro_bias_tau_s: T
    camera_white_m: T
    camera_slope: T
    camera_slope_correlation: T
    camera_bias_m: T
    camera_bias_tau_s: T
    camera_mount_m: T
    camera_period_s: T
    gyro_latency_s: T


def noise_table(profiles: list[FilterNoise[float]]) -> FilterNoise[Floats]:
    """Return the figures of the run's profiles, in their order."""
    return FilterNoise(*(np.array(figures) for figures in zip(*profiles, strict=True)))


def noise_of(table: FilterNoise[Floats], profile: int) -> FilterNoise[float]:
    """Return the figures of one of the profiles."""
    return FilterNoise(*(float(figures[profile]) for figures in table))
