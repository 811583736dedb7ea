"""Perfect sensors, and profiles that differ from them in what a test looks at."""

from gpsec.sensors.profiles import Camera, Gnss, Gyro, Heading, Odometer, SensorProfile

_ALWAYS = {"rate_hz": 1000.0, "latency_s": 0.0, "outages_per_h": 0.0, "outage_mean_s": 0.0}
_EXACT = {
    "gnss": (Gnss, {"white_m": 0.0, "bias_m": 0.0, "bias_tau_s": 100.0}),
    "gyro": (Gyro, {"angle_random_walk_deg_per_sqrt_h": 0.0, "bias_deg_per_h": 0.0, "bias_tau_s": 100.0}),
    "odometer": (Odometer, {"white_mps": 0.0, "scale_ratio": 0.0}),
    "heading": (Heading, {"white_deg": 0.0, "bias_deg": 0.0, "bias_tau_s": 100.0}),
    "camera": (
        Camera,
        {
            "white_m": 0.0,
            "bias_m": 0.0,
            "bias_tau_s": 100.0,
            "mount_m": 0.0,
            "range_m": 50.0,
            "field_of_view_deg": 60.0,
            "trust_limit_m": 10.0,
        },
    ),
}


def profile(name: str = "exact", **changes: dict[str, float]) -> SensorProfile:
    """Return perfect sensors, save for the figures in `changes`, by channel."""
    channels = {}
    for channel, (kind, figures) in _EXACT.items():
        values = _ALWAYS | figures | changes.get(channel, {})
        channels[channel] = kind(**values, sources=dict.fromkeys(values, "chosen by a test"))
    return SensorProfile(
        name=name, title="test", map_spacing_m=1.0, sources={"map_spacing_m": "chosen by a test"}, **channels
    )
