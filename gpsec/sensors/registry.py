"""The sensor profiles that can be chosen by name. Figures come from sources, never from fitting a score."""

from gpsec.core.registry import Registry
from gpsec.sensors import sources as s
from gpsec.sensors.profiles import Camera, Gnss, Gyro, Heading, Odometer, SensorProfile
from gpsec.sensors.simulators import simulated


def cite(source: str, *figures: str) -> dict[str, str]:
    """Return `source` for each of `figures`."""
    return dict.fromkeys(figures, source)


_NO_OUTAGE = cite(s.NEVER_OUT, "outages_per_h", "outage_mean_s")
_INERTIAL = cite(s.INERTIAL_RATE, "rate_hz") | _NO_OUTAGE
_GYRO = ("angle_random_walk_deg_per_sqrt_h", "bias_deg_per_h", "bias_tau_s")
_SIGMA = ("white_m", "bias_m")
_TAILS = ("tail_share", "tail_factor")
_OPENPILOT = cite(s.OPENPILOT_OFFSET, "mount_m") | cite(s.OPENPILOT_TRUST, "trust_limit_m")
_RENDERED = (
    cite(s.RENDERED_TAU, "bias_tau_s")
    | cite(s.RENDERED_TAILS, *_TAILS)
    | cite(s.RENDERED_SLOPE, "slope_correlation")
    | cite(s.LANE_RANGE, "range_m")
)


def _gyro(latency_s: float, latency_source: str, random_walk: float, bias: float, source: str) -> Gyro:
    return Gyro(
        rate_hz=100.0,
        latency_s=latency_s,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        angle_random_walk_deg_per_sqrt_h=random_walk,
        bias_deg_per_h=bias,
        bias_tau_s=100.0,
        sources=_INERTIAL | cite(latency_source, "latency_s") | cite(source, *_GYRO),
    )


def _odometer(
    latency_s: float, latency_source: str, white: float, white_source: str, scale: float, source: str
) -> Odometer:
    return Odometer(
        rate_hz=100.0,
        latency_s=latency_s,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        white_mps=white,
        scale_ratio=scale,
        sources=_INERTIAL
        | cite(latency_source, "latency_s")
        | cite(white_source, "white_mps")
        | cite(source, "scale_ratio"),
    )


def _heading(white: float, white_source: str, bias: float, source: str) -> Heading:
    return Heading(
        rate_hz=100.0,
        latency_s=0.0,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        white_deg=white,
        bias_deg=bias,
        bias_tau_s=100.0,
        sources=_INERTIAL
        | cite(s.SYNCHRONOUS, "latency_s")
        | cite(white_source, "white_deg")
        | cite(source, "bias_deg")
        | cite(s.HEADING_TAU, "bias_tau_s"),
    )


_DSD = SensorProfile(
    name="dsd",
    title="precise: RTK, mid-grade gyro, good lane camera, dense map",
    map_spacing_m=1.0,
    gnss=Gnss(
        rate_hz=10.0,
        latency_s=0.0,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        white_m=0.008,
        bias_m=0.010,
        bias_tau_s=900.0,
        sources=_NO_OUTAGE
        | cite(s.SYNCHRONOUS, "latency_s")
        | cite(s.RTK, "rate_hz", *_SIGMA)
        | cite(s.MULTIPATH, "bias_tau_s"),
    ),
    gyro=_gyro(0.0, s.SYNCHRONOUS, 0.25, 3.5, s.IMU381),
    odometer=_odometer(0.0, s.SYNCHRONOUS, 0.01, s.ODOMETER_BEST, 0.005, s.ODOMETER_BEST),
    heading=_heading(0.02, s.HEADING_SPLIT, 0.1, s.DUAL_ANTENNA),
    camera=Camera(
        rate_hz=30.0,
        latency_s=0.05,
        outages_per_h=36.0,
        outage_mean_s=1.0,
        white_m=0.04,
        bias_m=0.03,
        bias_tau_s=1.1,
        tail_share=0.05,
        tail_factor=3.0,
        slope_correlation=-0.9,
        visibility="place",
        mount_m=0.04,
        range_m=50.0,
        field_of_view_deg=52.0,
        trust_limit_m=0.30,
        sources=_OPENPILOT
        | _RENDERED
        | cite(s.FRAME_AND_A_HALF, "rate_hz", "latency_s")
        | cite(s.MOBILEYE, "outages_per_h")
        | cite(s.PAINT_GAP, "outage_mean_s")
        | cite(s.LANE_CAMERA_GOOD, *_SIGMA)
        | cite(s.SERIES_LENS, "field_of_view_deg"),
    ),
    sources=cite(s.PAPER_MAP, "map_spacing_m"),
)

_CARLA = SensorProfile(
    name="carla",
    title="larger errors: GNSS of 0.12 m, low-grade gyro, lane camera of 0.08 m",
    map_spacing_m=2.0,
    gnss=Gnss(
        rate_hz=20.0,
        latency_s=0.0,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        white_m=0.11,
        bias_m=0.05,
        bias_tau_s=100.0,
        sources=_NO_OUTAGE
        | cite(s.SYNCHRONOUS, "latency_s")
        | cite(s.OPENCDA, "rate_hz", "white_m")
        | cite(s.APOLLO, "bias_m")
        | cite(s.MULTIPATH, "bias_tau_s"),
    ),
    gyro=_gyro(0.0, s.SYNCHRONOUS, 0.75, 10.0, s.AHRS380),
    odometer=_odometer(0.0, s.SYNCHRONOUS, 0.056, s.OPENCDA, 0.01, s.ODOMETER_WORST),
    heading=_heading(0.1, s.OPENCDA, 0.1, s.DUAL_ANTENNA),
    camera=Camera(
        rate_hz=20.0,
        latency_s=0.0,
        outages_per_h=36.0,
        outage_mean_s=1.0,
        white_m=0.064,
        bias_m=0.048,
        bias_tau_s=1.1,
        tail_share=0.05,
        tail_factor=3.0,
        slope_correlation=-0.9,
        visibility="place",
        mount_m=0.04,
        range_m=40.0,
        field_of_view_deg=90.0,
        trust_limit_m=0.30,
        sources=_OPENPILOT
        | _RENDERED
        | cite(s.OPENCDA, "rate_hz")
        | cite(s.CARLA, "latency_s", "field_of_view_deg")
        | cite(s.MOBILEYE, "outages_per_h")
        | cite(s.PAINT_GAP, "outage_mean_s")
        | cite(s.LANE_CAMERA_MEAN, *_SIGMA),
    ),
    sources=cite(s.PAPER_MAP, "map_spacing_m"),
)

_NUSCENES = SensorProfile(
    name="nuscenes",
    title="fused pose within 0.1 m, mid-grade gyro, lane camera of 0.10 m, sparse map",
    map_spacing_m=5.0,
    gnss=Gnss(
        rate_hz=10.0,
        latency_s=0.0,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        white_m=0.02,
        bias_m=0.07,
        bias_tau_s=30.0,
        sources=_NO_OUTAGE
        | cite(s.SYNCHRONOUS, "latency_s")
        | cite(s.NUSCENES, "rate_hz", "white_m")
        | cite(s.APOLLO, "bias_m")
        | cite(s.FUSION_TAU, "bias_tau_s"),
    ),
    gyro=_gyro(0.0, s.SYNCHRONOUS, 0.25, 3.5, s.IMU381),
    odometer=_odometer(0.0, s.SYNCHRONOUS, 0.056, s.OPENCDA, 0.005, s.ODOMETER_BEST),
    heading=_heading(0.04, s.HEADING_SPLIT, 0.2, s.NUSCENES),
    camera=Camera(
        rate_hz=12.0,
        latency_s=0.1,
        outages_per_h=36.0,
        outage_mean_s=1.0,
        white_m=0.08,
        bias_m=0.06,
        bias_tau_s=1.1,
        tail_share=0.05,
        tail_factor=3.0,
        slope_correlation=-0.9,
        visibility="place",
        mount_m=0.04,
        range_m=40.0,
        field_of_view_deg=70.0,
        trust_limit_m=0.30,
        sources=_OPENPILOT
        | _RENDERED
        | cite(s.NUSCENES, "rate_hz", "field_of_view_deg")
        | cite(s.TWO_FRAMES, "latency_s")
        | cite(s.MOBILEYE, "outages_per_h")
        | cite(s.PAINT_GAP, "outage_mean_s")
        | cite(s.LANE_CAMERA_MEAN, *_SIGMA),
    ),
    sources=cite(s.AUTOWARE, "map_spacing_m"),
)

_WANDER = {"wander_mps": 0.015, "wander_tau_s": 3.0, "wander_hold_s": 50.0}
_RECEIVER = {"rate_hz": 5.0, "latency_s": 0.2, "outages_per_h": 2.0, "outage_mean_s": 5.0, "white_m": 0.002} | _WANDER
_RECEIVER_SOURCES = (
    cite(s.UBLOX, "rate_hz")
    | cite(s.STRUCTURE, "white_m", *_WANDER)
    | cite(s.COMMA_LATENCY, "latency_s")
    | cite(s.TUNNELS, "outages_per_h", "outage_mean_s")
    | cite(s.TWO_RECEIVERS, "common_share")
)

_CONSUMER = SensorProfile(
    name="consumer",
    title="series production: u-blox M8 in the open, low-grade gyro, usable lane camera",
    map_spacing_m=4.0,
    gnss=Gnss(
        **_RECEIVER,
        bias_m=1.05,
        bias_tau_s=600.0,
        common_share=0.8,
        sources=_RECEIVER_SOURCES | cite(s.DRIVES, "bias_m") | cite(s.STATIC_HOUR, "bias_tau_s"),
    ),
    gyro=Gyro(
        rate_hz=100.0,
        latency_s=0.02,
        outages_per_h=0.0,
        outage_mean_s=0.0,
        angle_random_walk_deg_per_sqrt_h=0.75,
        bias_deg_per_h=85.0,
        bias_tau_s=600.0,
        sources=_INERTIAL
        | cite(s.CAN_CYCLE, "latency_s")
        | cite(s.AHRS380, "angle_random_walk_deg_per_sqrt_h")
        | cite(s.LOGGED_GYROS, "bias_deg_per_h")
        | cite(s.GYRO_REST, "bias_tau_s"),
    ),
    odometer=_odometer(0.02, s.CAN_CYCLE, 0.04, s.COMMA_ODOMETER, 0.01, s.ODOMETER_WORST),
    heading=_heading(0.2, s.HEADING_SPLIT, 1.0, s.MTI_G),
    camera=Camera(
        rate_hz=20.0,
        latency_s=0.1,
        outages_per_h=90.0,
        outage_mean_s=2.0,
        white_m=0.022,
        bias_m=0.062,
        bias_tau_s=1.1,
        tail_share=0.05,
        tail_factor=3.0,
        slope_correlation=-0.9,
        visibility="place",
        mount_m=0.04,
        range_m=30.0,
        field_of_view_deg=38.0,
        trust_limit_m=0.30,
        sources=_OPENPILOT
        | _RENDERED
        | cite(s.TWO_FRAMES, "rate_hz", "latency_s")
        | cite(s.RENDERED_GAPS, "outages_per_h")
        | cite(s.PAINT_GAP_LONG, "outage_mean_s")
        | cite(s.RENDERED_WORN, *_SIGMA)
        | cite(s.NARROW_LENS, "field_of_view_deg"),
    ),
    sources=cite(s.HERE, "map_spacing_m"),
)

_URBAN = _CONSUMER.model_copy(
    update={
        "name": "urban",
        "title": "consumer in an urban canyon: multipath of 32 m that depends on the place",
        "gnss": Gnss(
            **_RECEIVER,
            bias_m=31.8,
            bias_tau_s=8.0,
            common_share=0.8,
            multipath_m=25.0,
            multipath_spread=0.49,
            multipath_length_m=71.0,
            sources=_RECEIVER_SOURCES
            | cite(s.BERLIN, "bias_m", "multipath_m", "multipath_spread")
            | cite(s.BERLIN_LENGTH, "bias_tau_s", "multipath_length_m"),
        ),
    }
)


def _take(made: object) -> tuple[str, SensorProfile] | None:
    return (made.name, made) if isinstance(made, SensorProfile) else None


PROFILES: Registry[SensorProfile] = Registry(
    "sensor profile",
    "gpsec.profiles",
    {profile.name: profile for profile in (_DSD, _CARLA, *simulated(_DSD, _CARLA), _NUSCENES, _CONSUMER, _URBAN)},
    _take,
)
