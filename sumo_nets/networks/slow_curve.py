"""A country road with slow turns of 150 to 600 m radius and one stretch of two lanes each way."""

from __future__ import annotations

from sumo_nets.networks.chain import trunk
from sumo_nets.plan import Plan, tmerc


def plan() -> Plan:
    """Return a trunk of 5.5 km near Weilheim, Bavaria, with three side roads."""
    result = Plan("slow_curve", tmerc(47.8402, 11.1421))
    trunk(
        result,
        (0.0, 0.0, 0.35),
        [
            [260.0, (-48.0, 400.0), 180.0, (62.0, 250.0), 150.0, (-25.0, 600.0), 160.0],
            [120.0, (-55.0, 180.0), 140.0, (70.0, 300.0), 220.0, (-20.0, 500.0), 150.0],
            [180.0, (28.0, 450.0), 160.0, (-80.0, 150.0), 200.0, (30.0, 350.0), 150.0],
            [140.0, (65.0, 200.0), 180.0, (-50.0, 280.0), 150.0, (35.0, 550.0), 240.0],
        ],
        [
            (80.0, [150.0, (40.0, 160.0), 180.0, (-60.0, 200.0), 160.0]),
            (-85.0, [160.0, (-35.0, 220.0), 150.0, (55.0, 150.0), 200.0]),
            (85.0, [140.0, (-45.0, 180.0), 200.0, (40.0, 240.0), 120.0]),
        ],
        lanes=[(1, 1), [(0.0, (1, 1)), (200.0, (2, 2)), (900.0, (1, 1))], (1, 1), (1, 1)],
        speed_kmh=80.0,
        width_m=3.5,
    )
    return result
