"""A long winding mountain road, one lane each way, with hairpins and sweeping curves."""

from __future__ import annotations

from sumo_nets.networks.chain import trunk
from sumo_nets.plan import Plan, tmerc


def plan() -> Plan:
    """Return a pass road of about 6 km near Andermatt, Switzerland, with three side roads."""
    result = Plan("mountain", tmerc(46.6357, 8.5940), curve_resolution_m=0.5)
    wiggle: list[float | tuple[float, float]] = [(35.0, 110.0), 40.0, (-70.0, 75.0), 50.0, (35.0, 130.0)]
    trunk(
        result,
        (0.0, 0.0, 0.6),
        [
            [160.0, *wiggle, 90.0, (-60.0, 60.0), 80.0, (100.0, 45.0), 120.0, (-40.0, 150.0), 90.0],
            [120.0, (168.0, 22.0), 190.0, (-165.0, 25.0), 210.0, (60.0, 90.0), 100.0, (-55.0, 120.0), 90.0],
            [100.0, (-80.0, 55.0), 70.0, *wiggle, 60.0, (75.0, 65.0), 130.0, (-30.0, 190.0), 120.0],
            [90.0, (-90.0, 40.0), 110.0, (90.0, 50.0), 80.0, (-45.0, 100.0), 60.0, (80.0, 80.0), 140.0],
        ],
        [
            (-85.0, [120.0, (60.0, 70.0), 90.0, (-80.0, 50.0), 120.0, (40.0, 100.0), 130.0]),
            (-80.0, [130.0, (-50.0, 80.0), 80.0, (70.0, 60.0), 150.0]),
            (85.0, [110.0, (-60.0, 60.0), 100.0, (50.0, 90.0), 160.0]),
        ],
        lanes=[(1, 1)] * 4,
        speed_kmh=60.0,
        width_m=3.25,
    )
    return result
