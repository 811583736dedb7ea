"""Who has to go over before its lane ends falls back behind those that drive beside it at its own speed."""

import pytest

from .driven import Driven, configured, numbers_of

NODES = """
id="west" x="0" y="0"
id="end" x="350" y="0"
id="east" x="600" y="0"
"""
EDGES = """
id="in" from="west" to="end" numLanes="2" speed="20"
id="on" from="end" to="east" numLanes="1" speed="20"
"""
CONNECTIONS = 'from="in" to="on" fromLane="1" toLane="0"'


@pytest.fixture(scope="module")
def merge(plain_net):
    """Return a function that gives a configuration for vehicles on a lane that ends, and the numbers of its lanes."""
    net = plain_net(NODES, EDGES, connections=CONNECTIONS)
    numbers = numbers_of(net)
    return lambda vehicles: (configured(net, '<route id="on" edges="in on"/>' + vehicles), numbers)


@pytest.mark.parametrize("apart_m", [-3, 0, 3])
def test_who_drives_abreast_goes_over_without_standing(merge, apart_m):
    """Two even cars at 20 m/s, side by side; behind them the road is empty."""
    kind = '<vType id="even" sigma="0" speedFactor="1" length="4"/>'
    cars = "".join(
        f'<vehicle id="{name}" type="even" depart="0" departLane="{lane}" departPos="{at_m}" departSpeed="20" '
        'route="on"/>'
        for name, lane, at_m in (("b", 1, 60 + apart_m), ("v", 0, 60))
    )
    with Driven(*merge(kind + cars)) as driven:
        slowest = 99.0
        for frame in driven.frames(40.0):
            driven.steer("v")
            if frame.step > 2 and "v" in driven.row:
                slowest = min(slowest, driven.session._actuation.now.speed_mps[driven.row["v"]])
        assert "v" not in driven.row
        assert slowest > 15.0
