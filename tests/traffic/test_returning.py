"""Vehicles that are steered out of their lane at an exit or in a roundabout come back, are SUMO's again and arrive."""

import libsumo
import numpy as np
import pytest

from gpsec.traffic.commands import CommandKind

from .driven import Driven, configured, numbers_of, steer

EXIT = (
    """
id="west" x="0" y="0"
id="begin" x="300" y="0"
id="end" x="520" y="0"
id="east" x="800" y="0"
id="down" x="800" y="-80"
""",
    """
id="before" from="west" to="begin" numLanes="2" speed="27.8"
id="beside" from="begin" to="end" numLanes="3" speed="27.8"
id="after" from="end" to="east" numLanes="2" speed="27.8"
id="ramp" from="end" to="down" numLanes="1" speed="16"
""",
    """
from="before" to="beside" fromLane="0" toLane="0"
from="before" to="beside" fromLane="0" toLane="1"
from="before" to="beside" fromLane="1" toLane="2"
from="beside" to="ramp" fromLane="0" toLane="0"
from="beside" to="after" fromLane="1" toLane="0"
from="beside" to="after" fromLane="2" toLane="1"
""",
)
# Counter-clockwise, with an arm to the south, the east and the north.
ROUNDABOUT = (
    """
id="s" x="0" y="-20"
id="e" x="20" y="0"
id="n" x="0" y="20"
id="w" x="-20" y="0"
id="south" x="0" y="-150"
id="east" x="150" y="0"
id="north" x="0" y="150"
""",
    """
id="se" from="s" to="e" priority="3" speed="8"
id="en" from="e" to="n" priority="3" speed="8"
id="nw" from="n" to="w" priority="3" speed="8"
id="ws" from="w" to="s" priority="3" speed="8"
id="in" from="south" to="s" priority="1" speed="13.9"
id="east_in" from="east" to="e" priority="1" speed="13.9"
id="out" from="n" to="north" priority="1" speed="13.9"
""",
    "",
)
# The route, on which edge the attack begins, and on which it ends.
STORIES = {
    "takes the exit, attacked up to the ramp": (EXIT, "before beside ramp", "before", "ramp"),
    "takes the exit, attacked beside it": (EXIT, "before beside ramp", "beside", "beside"),
    "drives past the exit": (EXIT, "before beside after", "before", "after"),
    "comes into the roundabout": (ROUNDABOUT, "in se en out", "in", "se"),
    "leaves the roundabout": (ROUNDABOUT, "in se en out", "se", "out"),
    "drives round": (ROUNDABOUT, "east_in en nw ws se en out", "en", "ws"),
}


@pytest.fixture(scope="module")
def nets(plain_net):
    """Return a function that gives the net of a place, and the numbers of its lanes."""
    made = {}

    def of(place):
        if place not in made:
            net = plain_net(place[0], place[1], connections=place[2])
            made[place] = net, numbers_of(net)
        return made[place]

    return of


OFTEN = [("takes the exit, attacked up to the ramp", 3.4), ("comes into the roundabout", -3.4), ("drives round", 3.4)]
CASES = [(story, lateral_m) for story in STORIES for lateral_m in (-3.4, 2.0, 3.4)]


@pytest.mark.parametrize(
    ("story", "lateral_m"),
    [pytest.param(*case, marks=() if case in OFTEN else pytest.mark.slow) for case in CASES],
)
def test_who_left_the_lane_comes_back(nets, story, lateral_m):
    place, route, first, last = STORIES[story]
    net, numbers = nets(place)
    behind = "".join(f'<vehicle id="o{k}" type="car" depart="{2 + 5 * k}" route="way"/>' for k in range(3))
    way = f'<route id="way" edges="{route}"/><vehicle id="v" type="car" depart="0" route="way"/>'
    edges = route.split()
    with Driven(configured(net, way + behind), numbers) as driven:
        wish_m = furthest_m = 0.0
        released = None
        for frame in driven.frames(110.0):
            if "v" not in driven.row:
                continue
            attacked = released is None and is_between(edges.index(first), edges.index(last))
            wish_m += np.clip((lateral_m if attacked else 0.0) - wish_m, -0.15, 0.15)
            furthest_m = max(furthest_m, abs(wish_m))
            if released is None and (attacked or wish_m):
                driven.steer("v", wish_m)
            elif released is None and furthest_m:
                driven.session.command(steer([driven.row["v"]], order=CommandKind.RELEASE))
                released = frame.step
            elif released is not None and frame.step > released + 30:
                assert abs(libsumo.vehicle.getLateralLanePosition("v")) < 0.3
        assert furthest_m > 1.9
        assert released is not None
        assert not driven.row
        assert frame.carried.stuck == frame.carried.teleports == 0


def is_between(first, last):
    """Return whether the vehicle is on an edge of its route from the first on, and before the middle of the last."""
    vehicle = libsumo.vehicle
    at, lane = vehicle.getRouteIndex("v"), vehicle.getLaneID("v")
    early = lane.startswith(":") or vehicle.getLanePosition("v") < 0.5 * libsumo.lane.getLength(lane)
    return first <= at < last or (at == last and early)
