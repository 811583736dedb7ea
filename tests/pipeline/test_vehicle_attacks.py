"""Attacks that vehicles carry, from SUMO's input files to the table of events."""

from collections.abc import Callable
from math import cos, dist, radians, sin
from pathlib import Path

import libsumo
import pandas as pd
import pytest

from gpsec.pipeline.build import lay_ground
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.traffic.body import axle_distance
from gpsec.traffic.session import SumoSession

REACH_M, HOLD_S, SETTLE_S = 40.0, 1.0, 3.0
ROUTES = """<routes>
    <vType id="car" maxSpeed="12" speedDev="0"/>
    <vType id="van" vClass="delivery" maxSpeed="19" speedDev="0" color="red">
        <param key="gpsec.attack" value="drift"/>
        <param key="gpsec.radius_m" value="40"/>
        <param key="gpsec.hold_s" value="1"/>
    </vType>
    <flow id="free" type="car" from="a" to="b" begin="0" period="6" number="3" departSpeed="max"/>
    <flow id="own" type="car" from="a" to="b" begin="3" period="6" number="2" departSpeed="max">
        <param key="gpsec.attack" value="constant_bias"/>
        <param key="gpsec.begin" value="12"/>
        <param key="gpsec.end" value="20"/>
    </flow>
    <trip id="spoofer" type="van" from="a" to="b" depart="18" departSpeed="max"/>
</routes>"""


@pytest.fixture
def scenario(tmp_path: Path, plain_net: Callable[..., Path]) -> Scenario:
    folder = tmp_path / "road"
    folder.mkdir()
    nodes = 'id="n0" x="0" y="0"\nid="n1" x="300" y="0"\nid="n2" x="900" y="40"'
    edges = 'id="a" from="n0" to="n1" numLanes="2" speed="20"\nid="b" from="n1" to="n2" numLanes="2" speed="20"'
    (folder / "road.net.xml").write_bytes(plain_net(nodes, edges).read_bytes())
    (folder / "road.rou.xml").write_text(ROUTES)
    (folder / "road.sumocfg").write_text(
        '<configuration><input><net-file value="road.net.xml"/><route-files value="road.rou.xml"/></input>'
        "</configuration>"
    )
    changes = ["plans=[]", "duration_s=60", f"fleet.settle_s={SETTLE_S}", "outcomes.bootstrap=2"]
    changes += ['detection.detectors=["chi_square"]']
    return load_scenario(folder, [parse_set(change) for change in changes])


def spans(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """First and last time at which each car is in the van's reach, by SUMO's positions and angles alone."""
    ground = lay_ground(scenario)
    born: dict[str, float] = {}
    seen: dict[str, list[float]] = {}
    with SumoSession(ground.options, ground.hd_map.lane_index, lambda departure: True) as session:
        for frame in session.frames(60.0):
            for departure in frame.departures:
                born[departure.vehicle_id] = frame.time_s
            if "spoofer" not in libsumo.vehicle.getIDList():
                continue
            van = libsumo.vehicle.getPosition("spoofer")
            for name in set(libsumo.vehicle.getIDList()) & born.keys():
                (x, y), angle = libsumo.vehicle.getPosition(name), radians(libsumo.vehicle.getAngle(name))
                axle_m = axle_distance(libsumo.vehicle.getLength(name))
                rear = x - axle_m * sin(angle), y - axle_m * cos(angle)  # SUMO counts clockwise from north
                if frame.time_s - born[name] >= SETTLE_S - 1e-6 and dist(rear, van) <= REACH_M:
                    seen.setdefault(name, []).append(frame.time_s)
    return {name: (times[0], times[-1]) for name, times in seen.items()}


def test_a_van_spoofs_whom_it_passes_and_a_flow_is_attacked_by_itself(
    scenario: Scenario, go: Callable[[Scenario], Path]
) -> None:
    events = pd.read_csv(go(scenario) / "events.csv")
    events = events[events.detector == "never"].set_index(["attack", "vehicle_id"]).sort_index()
    expected = spans(scenario)
    by_van = events.loc["van"]
    assert len(by_van) >= 3
    assert set(by_van.index) == set(expected)
    for name, (first_s, last_s) in expected.items():
        # The body swings a little behind SUMO's angle on a lane change: a step more or less.
        assert by_van.start_s[name] == pytest.approx(first_s, abs=0.11), name
        if not by_van.cut_short[name]:
            assert by_van.end_s[name] == pytest.approx(last_s + HOLD_S + 0.1, abs=0.11), name
    own = events.loc["own"]
    assert set(own.index) == {"own.0", "own.1"}
    # The run's own clock: the first step that ends at 12 s; the second car departs at 9 s and settles at 12 s.
    assert own.start_s.tolist() == pytest.approx([12.0, 12.0], abs=0.25)
    assert own.end_s.tolist() == pytest.approx([20.0, 20.0], abs=0.11)
    assert "spoofer" not in pd.read_csv(go(scenario) / "vehicles.csv").vehicle_id.to_numpy()
