"""A motorway of three lanes each way with clothoid curves and three interchanges."""

from __future__ import annotations

from sumo_nets.networks.motorway import Carriageway, Ramp, Steps, lay
from sumo_nets.plan import Plan, tmerc

POINTS = (
    (0.0, 0.0),
    (1900.0, 100.0, 1300.0),
    (3500.0, 1000.0, 1000.0),
    (5300.0, 900.0, 1600.0),
    (7000.0, 1800.0, 900.0),
    (8900.0, 1500.0),
)

OFF: Steps = (70.0, (-25.0, 160.0), 60.0, (-35.0, 90.0), 140.0)
ON: Steps = (80.0, (-20.0, 200.0), 70.0, (-40.0, 80.0), 150.0)


def plan() -> Plan:
    """Nine kilometres south of Hanover, Germany."""
    result = Plan("highway", tmerc(52.3080, 9.8350))
    ramps = (
        Ramp(700.0, True, OFF),
        Ramp(1650.0, False, ON),
        Ramp(3900.0, True, OFF),
        Ramp(4850.0, False, ON),
        Ramp(7200.0, True, OFF),
        Ramp(8150.0, False, ON),
    )
    shared = {"lanes": ((0.0, 3),), "speed_kmh": 120.0, "width_m": 3.75}
    lay(
        result,
        POINTS,
        Carriageway("eastbound", ramps=ramps, **shared),  # type: ignore[arg-type]
        Carriageway("westbound", ramps=ramps, **shared),  # type: ignore[arg-type]
    )
    return result
