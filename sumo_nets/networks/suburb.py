"""A suburb: narrower lanes, curved residential streets, one arterial road of three lanes and one of two."""

from __future__ import annotations

from sumo_nets.networks.grid import Grid, lay
from sumo_nets.plan import Plan, tmerc


def plan() -> Plan:
    """About 1 km by 0.8 km in the west of Graz, Austria."""
    result = Plan("suburb", tmerc(47.0610, 15.3920), curve_resolution_m=0.5)
    lay(
        result,
        Grid(
            columns=(0.0, 250.0, 530.0, 770.0, 1060.0),
            rows=(0.0, 300.0, 550.0, 830.0),
            shifts={
                (0, 0): (30.0, -15.0),
                (0, 2): (-25.0, 20.0),
                (1, 0): (-10.0, -25.0),
                (1, 2): (25.0, 15.0),
                (3, 0): (20.0, 25.0),
                (3, 2): (-25.0, -10.0),
                (3, 3): (15.0, 25.0),
                (4, 2): (30.0, 10.0),
            },
            column_lanes={2: 2},
            row_lanes={1: 3},
            omitted=frozenset({((0, 2), (0, 3)), ((3, 0), (4, 0)), ((0, 3), (1, 3))}),
            bows={
                ((0, 0), (1, 0)): (24.0, -24.0),
                ((0, 0), (0, 1)): (30.0,),
                ((0, 1), (0, 2)): (-28.0,),
                ((0, 2), (1, 2)): (-30.0, 30.0),
                ((1, 0), (1, 1)): (-26.0, 26.0),
                ((1, 1), (1, 2)): (30.0,),
                ((1, 2), (1, 3)): (-24.0, 24.0),
                ((1, 2), (2, 2)): (32.0,),
                ((2, 2), (3, 2)): (-28.0,),
                ((3, 1), (3, 2)): (20.0, -20.0),
                ((3, 2), (4, 2)): (24.0, -24.0),
                ((3, 2), (3, 3)): (30.0,),
                ((4, 1), (4, 2)): (-28.0,),
                ((3, 3), (4, 3)): (26.0,),
            },
            stubs={
                (0, 1): 180.0,
                (4, 1): 0.0,
                (2, 0): 270.0,
                (2, 3): 90.0,
                (0, 2): 170.0,
                (4, 2): 8.0,
                (3, 0): 275.0,
                (1, 3): 95.0,
            },
            roundabouts=frozenset({(3, 2)}),
            unsignalled=frozenset({(0, 1)}),
            width_m=2.95,
            arterial_kmh=60.0,
            street_kmh=30.0,
            bow_radius_m=55.0,
        ),
    )
    return result
