"""Why a vehicle stands: for a reason, at the end of all who wait for each other, or for none."""

import libsumo
import pytest

from gpsec.traffic import waits

from .driven import Driven, configured, numbers_of

NODES = """
id="cross" x="0" y="0" type="priority" radius="12"
id="north" x="0" y="200"
id="south" x="0" y="-200"
id="west" x="-200" y="0"
id="east" x="200" y="0"
"""
EDGES = "\n".join(
    f'id="{place}_in" from="{place}" to="cross" priority="{priority}" speed="13.9"\n'
    f'id="{place}_out" from="cross" to="{place}" priority="{priority}" speed="13.9"'
    for place, priority in (("north", 2), ("south", 2), ("west", 1), ("east", 1))
)
LAZY = '<vType id="lazy" maxSpeed="1.5" sigma="0" length="2"/>'


@pytest.fixture(scope="module")
def cross(plain_net):
    """Return a function that gives a configuration for cars at a junction of a main road and a minor one."""
    net = plain_net(NODES, EDGES)
    numbers = numbers_of(net)
    return lambda *cars: (configured(net, LAZY + "".join(text for _, text in sorted(cars))), numbers)


def car(depart_s, name, edges, kind="car", to_end_m=5):
    """Return when a car departs and its text, for SUMO reads them by time."""
    where = f'depart="{depart_s}" departPos="-{to_end_m}" departSpeed="max"'
    return depart_s, f'<vehicle id="{name}" type="{kind}" {where}><route edges="{edges}"/></vehicle>'


# One comes from the south every ten seconds; who is lazy needs more than that to cross, and there is often nobody
# within the junction, or near it.
STREAM = [car(10 * k, f"s{k}", "south_in north_out", to_end_m=180) for k in range(4)]
BEFORE = [car(0, "before", "east_in south_out", "lazy")]
MIDDLE = [car(0, "middle", "north_in east_out", "lazy"), car(4, "behind", "north_in south_out")]


@pytest.mark.parametrize(
    ("cars", "lanes"),
    [(BEFORE, {"before": "east_in_0"}), (MIDDLE, {"middle": ":cross_2_0", "behind": ":cross_1_0"})],
)
def test_who_waits_for_those_with_the_right_of_way_is_not_stuck(cross, cars, lanes):
    """One turns left from the minor road, one from the main road, and behind its tail one goes straight on."""
    stood = dict.fromkeys(lanes, 0)
    with Driven(*cross(*cars, *STREAM)) as driven:
        for frame in driven.frames(30.0):
            for name in lanes.keys() & driven.row.keys():
                driven.steer(name)
                if frame.step % 10 == 0 and libsumo.vehicle.getSpeed(name) < waits.HALTED_MPS:
                    stood[name] += 1
                    assert not waits.is_stuck(name, "".__contains__)
        assert {name: libsumo.vehicle.getLaneID(name) for name in lanes} == lanes
    assert min(stood.values()) > 18


def test_who_stands_in_a_junction_and_is_passed_behind_is_stuck(cross):
    """It has crossed the way of the others and stands for no reason."""
    looks = []
    with Driven(*cross(car(0, "v", "east_in west_out", "slow"), *STREAM)) as driven:
        for frame in driven.frames(30.0):
            if driven.place["v"][0] < -4.0:
                libsumo.vehicle.setSpeed("v", 0.0)
                if frame.step % 10 == 0 and libsumo.vehicle.getSpeed("v") < waits.HALTED_MPS:
                    looks.append(waits.is_stuck("v", "".__contains__))
        assert libsumo.vehicle.getLaneID("v") == ":cross_4_0"
        assert "s0" not in driven.row  # it has arrived
    assert len(looks) > 18
    assert all(looks)


@pytest.mark.parametrize(
    ("awaited", "with_reason", "stuck"),
    [
        ({"a": []}, "", "a"),
        ({"a": []}, "a", ""),
        ({"a": ["b"], "b": ["a"], "c": ["a"]}, "", "ab"),
        ({"a": ["b"], "b": ["a", "d"], "c": ["a"], "d": []}, "d", ""),
        ({"a": ["b"], "b": ["c"], "c": []}, "", "c"),
    ],
)
def test_stuck_is_who_waits_for_nobody_or_in_a_circle(monkeypatch, awaited, with_reason, stuck):
    monkeypatch.setattr(waits, "_awaited", awaited.__getitem__)
    monkeypatch.setattr(waits, "_has_reason", with_reason.__contains__)
    assert "".join(name for name in awaited if waits.is_stuck(name, "".__contains__)) == stuck
