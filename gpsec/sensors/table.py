"""The profiles of a run as arrays for kernels, one row a profile, in SI units and per step."""

from collections.abc import Callable, Sequence
from math import exp, inf, pi, radians, sqrt
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.sensors.canyons import NO_MULTIPATH
from gpsec.sensors.faults import fault_row
from gpsec.sensors.profiles import Channel, SensorProfile
from gpsec.sensors.smooth import wander_row

# Columns of a channel: samples per step (1 means one in every step); latency in steps, with its fraction; probability
# per step that an outage begins and that it is over; σ of the white noise of a sample; stationary σ of the bias (of
# the odometer: of its scale). Over one step the bias becomes DECAY·bias + KICK·n, with n standard normal.
TICKS, LATENCY, OUTAGE_BEGIN, OUTAGE_END, WHITE, BIAS, DECAY, KICK = range(8)
# Further columns of the camera: σ of the mounting offset; length of lane that is fitted on a straight road; half of
# the field of view in rad; largest stated σ with which a lane is reported; true σ of its errors over those it states.
MOUNT, RANGE, HALF_VIEW, TRUST, UNKNOWN = range(8, 13)


class ProfileTable(NamedTuple):
    """The channels of P profiles, a row each; see the columns above. Errors are in m, rad/s, m/s, rad and m.

    Attributes:
        gnss, gyro, odometer, heading: (P, 8).
        camera: (P, 13).
        wander: (P, 7), see `gpsec.sensors.smooth`.
        faults: (P, 7), see `gpsec.sensors.faults`.
        common: (P,) share of the variance of the slow error of fixes that all receivers have in common.
        multipath: (P, 3), see `gpsec.sensors.canyons`.
    """

    gnss: Floats
    gyro: Floats
    odometer: Floats
    heading: Floats
    camera: Floats
    wander: Floats
    faults: Floats
    common: Floats
    multipath: Floats


def angle_random_walk_rps(arw_deg_per_sqrt_h: float, mean_s: float) -> float:
    """Return σ in rad/s of a yaw rate averaged over `mean_s`: ARW/60 is °/√s, and the mean of dt has 1/√dt of it."""
    return radians(arw_deg_per_sqrt_h / 60.0) / sqrt(mean_s)


def _channel(
    profiles: Sequence[SensorProfile],
    step_s: float,
    channel: Callable[[SensorProfile], Channel],
    errors: Callable[[SensorProfile], tuple[float, float, float]],
) -> Floats:
    rows = []
    for profile in profiles:
        of = channel(profile)
        white, bias, tau_s = errors(profile)
        decay = exp(-step_s / tau_s)
        rows.append(
            (
                of.rate_hz * step_s,
                of.latency_s / step_s,
                1.0 - exp(-of.outages_per_h * step_s / 3600.0),
                1.0 - exp(-step_s / of.outage_mean_s) if of.outage_mean_s > 0.0 else 1.0,
                white,
                bias,
                decay,
                bias * sqrt(1.0 - decay * decay),
            )
        )
    table = np.array(rows)
    # 10 Hz at a step of 0.1 s is one sample a step, whatever the last bit of the product says.
    table[table[:, TICKS] > 1.0 - 1e-9, TICKS] = 1.0
    return table


def _check(profiles: Sequence[SensorProfile]) -> None:
    names = [profile.name for profile in profiles]
    if not names:
        raise GpsecError("sensors: expected at least one sensor profile, found none")
    for name in names:
        if names.count(name) > 1:
            raise GpsecError(f"sensors: expected each sensor profile once, found '{name}' {names.count(name)} times")


def _multipath_row(profile: SensorProfile) -> tuple[float, float, float]:
    of = profile.gnss
    if of.multipath_m is None or of.multipath_spread is None or of.multipath_length_m is None:
        return NO_MULTIPATH
    return of.multipath_m, of.multipath_spread, of.multipath_length_m


def pack(profiles: Sequence[SensorProfile], step_s: float) -> ProfileTable:
    """Return the tables of (P,) profiles for a loop of `step_s`.

    Raises:
        GpsecError: there is no profile, or one appears twice.
    """
    _check(profiles)
    rps_of_deg_per_h = pi / 180.0 / 3600.0
    lenses = [
        (c.mount_m, c.range_m, radians(c.field_of_view_deg) / 2.0, c.trust_limit_m, 1.0)
        for c in (profile.camera for profile in profiles)
    ]
    camera = _channel(
        profiles,
        step_s,
        lambda p: p.camera,
        lambda p: (p.camera.white_m, p.camera.bias_m, p.camera.bias_tau_s),
    )
    return ProfileTable(
        gnss=_channel(
            profiles,
            step_s,
            lambda p: p.gnss,
            lambda p: (p.gnss.white_m, p.gnss.offset_m, inf if p.gnss.is_lasting else p.gnss.bias_tau_s),
        ),
        gyro=_channel(
            profiles,
            step_s,
            lambda p: p.gyro,
            lambda p: (
                # A sample stands for the time until the next one, in which it is held.
                angle_random_walk_rps(p.gyro.angle_random_walk_deg_per_sqrt_h, max(step_s, 1.0 / p.gyro.rate_hz)),
                p.gyro.bias_deg_per_h * rps_of_deg_per_h,
                p.gyro.bias_tau_s,
            ),
        ),
        odometer=_channel(
            profiles,
            step_s,
            lambda p: p.odometer,
            lambda p: (p.odometer.white_mps, p.odometer.scale_ratio, float("inf")),
        ),
        heading=_channel(
            profiles,
            step_s,
            lambda p: p.heading,
            lambda p: (radians(p.heading.white_deg), radians(p.heading.bias_deg), p.heading.bias_tau_s),
        ),
        camera=np.concatenate([camera, lenses], axis=1),
        wander=np.array([wander_row(profile.gnss.wander, step_s) for profile in profiles]),
        faults=np.array([fault_row(profile.camera, step_s) for profile in profiles]),
        common=np.array([profile.gnss.common_share or 0.0 for profile in profiles]),
        multipath=np.array([_multipath_row(profile) for profile in profiles]),
    )
