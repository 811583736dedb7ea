"""On a road of three lanes SUMO lets who has to go over by two stand 40 m before its end, where nobody goes over."""

import pytest

from .driven import Driven, configured, numbers_of

NODES = """
id="west" x="0" y="0"
id="fork" x="250" y="0"
id="north" x="250" y="150"
id="east" x="400" y="0"
id="far" x="250" y="300"
"""
EDGES = """
id="in" from="west" to="fork" numLanes="3" speed="13.9"
id="left" from="fork" to="north" numLanes="1" speed="13.9"
id="on" from="fork" to="east" numLanes="2" speed="13.9"
id="round" from="east" to="north" numLanes="1" speed="13.9"
id="goal" from="north" to="far" numLanes="1" speed="13.9"
"""
CONNECTIONS = """
from="in" to="left" fromLane="2" toLane="0"
from="in" to="on" fromLane="0" toLane="0"
from="in" to="on" fromLane="1" toLane="1"
"""
LEFT = '<route id="left" edges="in left goal"/>'


@pytest.fixture(scope="module")
def fork(plain_net):
    """Return a function that gives a configuration for routes on a fork, and the numbers of its lanes."""
    net = plain_net(NODES, EDGES, connections=CONNECTIONS)
    numbers = numbers_of(net)
    return lambda routes: (configured(net, LEFT + routes), numbers)


@pytest.mark.parametrize(("lane", "lateral_m"), [(2, -6.4), (1, -3.2), (2, 3.2)])
def test_who_is_displaced_by_lanes_passes_the_junction(fork, lane, lateral_m):
    """From lane 1 the path goes over to the left one, with the displacement kept; nobody else is on the road."""
    with Driven(*fork(f'<vehicle id="v" type="car" depart="0" departLane="{lane}" route="left"/>')) as driven:
        slowest = 99.0
        for frame in driven.frames(60.0):
            before = driven.place.get("v")
            driven.steer("v", min(0.1 * frame.step, abs(lateral_m)) * (1 if lateral_m > 0 else -1))
            if before is not None and 60 < frame.step < 180:
                slowest = min(slowest, driven.session._actuation.now.speed_mps[driven.row["v"]])
        assert "v" not in driven.row
        assert slowest > 3.0


def test_who_is_let_in_by_nobody_two_lanes_beside_its_own_takes_another_way(fork):
    """A queue stands beside it, up to 45 m before the end; straight on it comes round to the same goal."""
    queue = "".join(
        f'<vehicle id="q{k}" type="car" depart="0" departLane="1" departPos="{-45 - 6 * k}" departSpeed="0" '
        f'route="left"><stop lane="in_1" endPos="{-45 - 6 * k}" duration="1000"/></vehicle>'
        for k in range(24)
    )
    slow = '<vehicle id="v" type="slow" depart="0" departLane="0" departPos="150" departSpeed="5" route="left"/>'
    with Driven(*fork(queue + slow)) as driven:
        for _ in driven.frames(40.0):
            driven.steer("v")
        assert driven.place["v"][0] > 260.0
        assert driven.place["v"][1] < 0.0
