"""Figures that real logs ask for and that no profile has yet: detectors are still calibrated on the former ones."""

from gpsec.sensors import sources as s
from gpsec.sensors.profiles import Gnss

_FITTED = ("white_m", "wander_mps", "wander_tau_s", "wander_hold_s")

CONSUMER_GNSS = Gnss(
    rate_hz=5.0,
    latency_s=0.1,
    outages_per_h=2.0,
    outage_mean_s=5.0,
    white_m=0.002,
    bias_m=1.05,
    bias_tau_s=600.0,
    wander_mps=0.015,
    wander_tau_s=3.0,
    wander_hold_s=50.0,
    common_share=0.8,
    sources={
        "rate_hz": s.UBLOX,
        "latency_s": s.RECEIVER_LATENCY,
        "outages_per_h": s.TUNNELS,
        "outage_mean_s": s.TUNNELS,
        "bias_m": s.DRIVES,
        "bias_tau_s": s.STATIC_HOUR,
        "common_share": s.TWO_RECEIVERS,
        **dict.fromkeys(_FITTED, s.STRUCTURE),
    },
)
"""A receiver such as a u-blox M8 in the open; the candidate for `consumer`."""
