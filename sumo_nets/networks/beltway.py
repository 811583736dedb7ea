"""A section of an urban ring motorway with two to four lanes, curves of 300 to 1000 m radius and short ramps."""

from __future__ import annotations

from sumo_nets.networks.motorway import Carriageway, Ramp, Steps, lay
from sumo_nets.plan import Plan, tmerc

POINTS = (
    (0.0, 0.0),
    (700.0, 350.0, 500.0),
    (1700.0, 300.0, 400.0),
    (2300.0, -500.0, 320.0),
    (1900.0, -1400.0, 600.0),
    (2300.0, -2500.0, 900.0),
    (2200.0, -3600.0),
)

RAMP: Steps = (45.0, (-40.0, 80.0), 40.0, (-35.0, 60.0), 110.0)


def plan() -> Plan:
    """Five kilometres in the south-east of Vienna, Austria."""
    result = Plan("beltway", tmerc(48.1790, 16.4100))
    southbound = Carriageway(
        "southbound",
        lanes=((0.0, 2), (1150.0, 3), (2900.0, 4), (3900.0, 3)),
        ramps=(
            Ramp(500.0, True, RAMP, 180.0),
            Ramp(1100.0, False, RAMP, 220.0),
            Ramp(2050.0, True, RAMP, 200.0),
            Ramp(2800.0, False, RAMP, 220.0),
            Ramp(4200.0, True, RAMP, 200.0),
        ),
        speed_kmh=90.0,
        width_m=3.4,
    )
    northbound = Carriageway(
        "northbound",
        lanes=((0.0, 3), (1200.0, 4), (2100.0, 3), (3700.0, 2)),
        ramps=(
            Ramp(500.0, False, RAMP, 220.0),
            Ramp(2500.0, True, RAMP, 200.0),
            Ramp(3100.0, False, RAMP, 220.0),
            Ramp(4200.0, True, RAMP, 180.0),
        ),
        speed_kmh=90.0,
        width_m=3.4,
    )
    lay(result, POINTS, southbound, northbound)
    return result
