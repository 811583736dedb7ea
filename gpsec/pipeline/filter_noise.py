"""What the filters are told of a sensor profile: its data sheet, in the units of the loop."""

from math import pi, radians, sqrt

from gpsec.filters.noise import FilterNoise
from gpsec.sensors.profiles import SensorProfile, residual_sigma_m


def filter_noise(profile: SensorProfile, step_s: float) -> FilterNoise[float]:
    """Return the figures of a profile for filters that run at `step_s`."""
    # Over the time in which a sample is held, its error lasts, and that of the way grows like it, not like its root.
    held_steps = max(1.0 / profile.odometer.rate_hz / step_s, 1.0)
    walk = profile.gyro.angle_random_walk_deg_per_sqrt_h / 60.0 * pi / 180.0
    return FilterNoise(
        gnss_white_m=profile.gnss.white_m,
        gnss_bias_m=profile.gnss.bias_m,
        gnss_bias_tau_s=profile.gnss.bias_tau_s,
        gnss_period_s=max(1.0 / profile.gnss.rate_hz, step_s),
        odometer_white_mps=profile.odometer.white_mps * sqrt(held_steps),
        odometer_scale=profile.odometer.scale_ratio,
        gyro_white_rps=walk / sqrt(step_s),
        gyro_bias_rps=radians(profile.gyro.bias_deg_per_h / 3600.0),
        heading_rad=radians(sqrt(profile.heading.white_deg**2 + profile.heading.bias_deg**2)),
        residual_m=residual_sigma_m(profile),
        gyro_bias_tau_s=profile.gyro.bias_tau_s,
        camera_white_m=profile.camera.white_m,
        # C1 of a cubic that is fitted to the whole range (docs/sensors.md).
        camera_slope=profile.camera.white_m * sqrt(75.0) / profile.camera.range_m,
        camera_slope_correlation=profile.camera.slope_correlation or 0.0,
        camera_bias_m=profile.camera.bias_m,
        camera_bias_tau_s=profile.camera.bias_tau_s,
        camera_mount_m=profile.camera.mount_m,
        camera_period_s=max(1.0 / profile.camera.rate_hz, step_s),
        gyro_latency_s=profile.gyro.latency_s,
    )
