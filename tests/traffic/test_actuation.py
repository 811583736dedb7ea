"""Vehicles that are steered from outside: where they are, who follows them, how they get through junctions."""

import libsumo
import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.controlled import LANE_CHANGING, ControlledSession
from gpsec.traffic.options import resolve_options
from gpsec.traffic.remote import RemoteSession

from .driven import CAR, LONG, Driven, everybody, nobody, steer

FLOWS = (
    CAR
    + '<flow id="f" type="car" begin="0" end="60" period="2" from="A0B0" to="B2C2"/>'
    + '<flow id="g" type="car" begin="0" end="60" period="3" from="C2B2" to="B0A0"/>'
)


def test_without_commands_everybody_drives_as_in_plain_sumo(scenario, lane_index):
    """Positions of all vehicles, every step, against libsumo under the same options; also where nobody is equipped."""
    options = resolve_options(scenario(FLOWS), seed=3, closed_loop=True)
    expected = []
    libsumo.start(["sumo", *options.arguments])
    for _ in range(400):
        libsumo.simulation.step()
        for name in libsumo.simulation.getDepartedIDList():
            for key, value in LANE_CHANGING.items():
                libsumo.vehicle.setParameter(name, f"laneChangeModel.{key}", value)
        expected.append({name: libsumo.vehicle.getPosition(name) for name in libsumo.vehicle.getIDList()})
    libsumo.close()
    assert max(map(len, expected)) > 8
    with Driven(options.config, lane_index) as driven:
        driven.session.close()
        driven.session = ControlledSession(options, lane_index, everybody)
        for frame, places in zip(driven.frames(40.0), expected, strict=True):
            assert {name: tuple(place) for name, place in driven.place.items()} == places
            assert frame.carried is not None
            assert not len(frame.carried.others.number)
    with ControlledSession(options, lane_index, nobody) as session:
        for frame, places in zip(session.frames(40.0), expected, strict=True):
            others = frame.carried.others
            found = dict(zip(others.sumo_id, map(tuple, others.front_m.tolist()), strict=True))
            assert found == places


@pytest.mark.parametrize("lateral_m", [0.0, 0.9, -2.2, 5.0, -7.0])
def test_a_vehicle_is_where_it_is_told_to_be(scenario, lane_index, lateral_m):
    """On A0B0, which leads east from x = 0: displacement is along y, from the middle of the lane it was taken on."""
    config = scenario(CAR + LONG + '<vehicle id="v" type="car" depart="0" departLane="1" route="long"/>')
    with Driven(config, lane_index) as driven:
        found = []
        for frame in driven.frames(12.0):
            wished = np.clip(0.3 * (frame.step - 20), 0.0, abs(lateral_m)) * np.sign(lateral_m)
            driven.steer("v", wished)
            if 20 < frame.step < 100 and driven.place["v"][0] < 195.0:
                found.append((driven.place["v"][1] - middle_y("A0B0_1"), driven.wished))
            driven.wished = wished
        off = np.array([place - wish for place, wish in found])
        assert len(found) > 50
        assert np.abs(off).max() < 0.005
        assert abs(found[-1][0] - lateral_m) < 0.005


def middle_y(lane):
    return libsumo.lane.getShape(lane)[0][1]


@pytest.mark.parametrize("lateral_m", [2.2, -2.2, 0.0])
@pytest.mark.parametrize("route", ["long", "left"])
def test_a_car_off_its_lane_passes_junctions(scenario, lane_index, lateral_m, route):
    config = scenario(CAR + LONG + f'<vehicle id="v" type="car" depart="0" departLane="0" route="{route}"/>')
    with Driven(config, lane_index) as driven:
        last, moved = None, []
        for frame in driven.frames(120.0):
            driven.steer("v", np.clip(0.1 * frame.step, 0.0, abs(lateral_m)) * np.sign(lateral_m))
            if last is not None and "v" in driven.place:
                moved.append(np.hypot(*(driven.place["v"] - last)))
            last = driven.place.get("v")
        assert "v" not in driven.row
        assert frame.on_road == 0
        assert frame.time_s < 100.0
        assert max(moved) < 0.1 * 13.9 * 1.1 + 0.6  # no jump, at junctions and where the path goes over either


def test_a_straddler_is_followed_and_not_driven_through(scenario, lane_index):
    """A car at 5 m/s half a metre over the line between two lanes: whoever comes stays behind, in either lane."""
    cars = '<vehicle id="s" type="slow" depart="0" departLane="0" route="long"/>' + "".join(
        f'<vehicle id="f{lane}" type="car" depart="{4 + lane}" departLane="{lane}" departSpeed="max" route="long"/>'
        for lane in (0, 1)
    )
    with Driven(scenario(CAR + LONG + cars), lane_index) as driven:
        gaps = {"f0": [], "f1": []}
        for _ in driven.frames(30.0):
            driven.steer("s", 1.6)
            if "s" in driven.place and driven.place["s"][0] < 170.0:
                for name in gaps.keys() & driven.place.keys():
                    gaps[name].append(driven.place["s"][0] - 4.0 - driven.place[name][0])
        assert min(map(min, gaps.values())) > 0.5
        assert max(map(min, gaps.values())) < 15.0


def test_a_wreck_holds_its_lane_without_a_teleport(scenario, lane_index):
    """Two of them block both lanes; they and the queue stay for five minutes, in which SUMO would move them on."""
    cars = "".join(f'<vehicle id="v{k}" type="car" depart="{2 * k}" departLane="0" route="long"/>' for k in range(3))
    blocked = '<vehicle id="w" type="car" depart="0" departLane="1" route="long"/>'
    with Driven(scenario(CAR + LONG + blocked + cars), lane_index) as driven:
        for frame in driven.frames(340.0):
            commands = [driven.row[name] for name in ("v0", "w") if name in driven.row and frame.step > 50]
            driven.session.command(steer(commands, 0.0, 8.0))
            if frame.step == 120:
                stood = dict(driven.place)
        assert frame.carried.teleports == 0
        assert {"v0", "v1", "v2", "w"} <= set(driven.place)
        np.testing.assert_array_equal(driven.place["v0"], stood["v0"])
        np.testing.assert_array_equal(driven.place["w"], stood["w"])


def test_a_path_that_does_not_lead_on_goes_over_to_the_lane_that_does(scenario, lane_index):
    """To turn left at B0 one needs the left lane; the car is steered from its departure on the right one."""
    config = scenario(CAR + LONG + '<vehicle id="v" type="car" depart="0" departLane="0" route="left"/>')
    with Driven(config, lane_index) as driven:
        paths = []
        for frame in driven.frames(100.0):
            driven.steer("v")
            paths += frame.carried.path.tolist()
        names = {index: name for name, index in lane_index.items()}
        order = list(dict.fromkeys(names[path] for path in paths))
        assert order[:2] == ["A0B0_0", "A0B0_1"]
        assert frame.on_road == 0


def test_who_cannot_get_over_drives_on_and_takes_another_way(scenario, lane_index):
    """Only the left lane of A0B0 leads to the left, and a queue stands on it that lets nobody in."""
    queue = "".join(
        f'<vehicle id="q{k}" type="car" depart="0" departLane="1" departPos="{-1 - 6 * k}" departSpeed="0" '
        f'route="left"><stop lane="A0B0_1" endPos="{-1 - 6 * k}" duration="1000"/></vehicle>'
        for k in range(28)
    )
    config = scenario(CAR + LONG + queue + '<vehicle id="v" type="car" depart="1" departLane="0" route="left"/>')
    with Driven(config, lane_index) as driven:
        stuck = []
        for frame in driven.frames(90.0):
            driven.steer("v")
            stuck.append(frame.carried.stuck)
        assert "v" not in driven.row
        assert stuck[-1] == 0


def test_who_stands_does_not_slide_across_the_road(scenario, lane_index):
    """The car goes over to the left lane, to turn left at B0, when it has to brake: it stands between the lanes."""
    config = scenario(CAR + LONG + '<vehicle id="v" type="car" depart="0" departLane="0" route="left"/>')
    with Driven(config, lane_index) as driven:
        across = []
        for frame in driven.frames(100.0):
            driven.steer("v", brake_mps2=8.0 if 1 <= frame.step < 130 else 0.0)
            if frame.step < 160:
                across.append(driven.place["v"][1])
        right, left = middle_y("A0B0_0"), middle_y("A0B0_1")
        assert np.ptp(across[60:130]) < 1e-9
        assert right + 0.5 < across[60] < left - 0.5
        assert across[159] == pytest.approx(left, abs=0.001)
        assert frame.on_road == 0


def test_sumos_own_vehicles_do_not_slide_either(scenario, lane_index):
    config = scenario(CAR + LONG + '<vehicle id="v" type="car" depart="0" departLane="0" route="long"/>')
    with Driven(config, lane_index) as driven:
        bounds = []
        for frame in driven.frames(4.0):
            if 5 <= frame.step < 20:
                driven.steer("v")
            elif frame.step == 20:
                driven.session.command(steer([driven.row["v"]], order=CommandKind.RELEASE))
            bounds.append(float(libsumo.vehicle.getParameter("v", "laneChangeModel.lcMaxSpeedLatStanding")))
        assert bounds == 5 * [0.0] + 15 * [1.0] + 20 * [0.0]


def test_a_released_vehicle_is_sumos_again(scenario, lane_index):
    config = scenario(CAR + LONG + '<vehicle id="v" type="car" depart="0" departLane="0" route="left"/>')
    with Driven(config, lane_index) as driven:
        for frame in driven.frames(100.0):
            if frame.step < 30:
                driven.steer("v", 0.5)
            elif frame.step == 30:
                driven.session.command(steer([driven.row["v"]], order=CommandKind.RELEASE))
            elif frame.step == 32:
                assert libsumo.vehicle.getLaneChangeMode("v") == 1621
                assert not len(frame.carried.rows)
        assert frame.on_road == 0
        assert frame.time_s < 60.0


def test_who_is_not_of_the_fleet_brakes_and_is_removed_by_number(scenario, lane_index):
    config = scenario(FLOWS)
    with ControlledSession(resolve_options(config, seed=1, closed_loop=True), lane_index, nobody) as session:
        speeds = []
        for frame in session.frames(20.0):
            others = frame.carried.others
            at = others.number == 0
            speeds += others.speed_mps[at].tolist()
            if 50 <= frame.step < 150:
                session.command(steer([0], 0.0, 3.0, CommandKind.BRAKE, others=True))
            if frame.step == 170:
                session.command(steer([0], order=CommandKind.REMOVE, others=True))
                gone = others.sumo_id[int(np.flatnonzero(at)[0])]
        assert speeds[149] == 0.0
        assert np.diff(speeds[52:70]) == pytest.approx(-0.3, abs=0.01)
        assert frame.carried.removed == 1
        assert gone not in others.sumo_id


def test_commands_of_a_step_act_in_the_step_after_the_next(scenario, lane_index):
    """In a process of its own SUMO simulates a step while the one before is evaluated."""
    options = resolve_options(scenario(FLOWS), seed=3, closed_loop=True)
    with ControlledSession(options, lane_index, everybody) as session:
        here, waiting = [], [Commands.none(), Commands.none()]
        for frame in session.frames(30.0):
            here.append(frame)
            waiting.append(swerve(frame))
            session.command(waiting[frame.step + 1])
    with RemoteSession(options, lane_index, everybody, controlled=True) as session:
        there = []
        for frame in session.frames(30.0):
            there.append(frame)
            session.command(swerve(frame))
    assert len(here) == len(there) == 300
    for one, other in zip(here, there, strict=True):
        np.testing.assert_array_equal(one.front_m, other.front_m)
        np.testing.assert_array_equal(one.carried.surplus_m, other.carried.surplus_m)
        np.testing.assert_array_equal(one.carried.path, other.carried.path)
    assert any(np.abs(one.carried.surplus_m).max(initial=0.0) > 0.3 for one in here)


def swerve(frame):
    return steer(frame.rows.tolist(), 1.5 * np.sin(0.05 * frame.step + frame.rows))


def test_the_closed_loop_says_what_it_sets_and_refuses_a_net_without_sublanes(scenario, lane_index):
    config = scenario(FLOWS)
    options = resolve_options(config, seed=1, closed_loop=True)
    said = " ".join(options.notes)
    assert all(name in said for name in ("time-to-teleport", "thread-rngs", "collision.action", "lcSigma"))
    assert options.arguments[options.arguments.index("--time-to-teleport") + 1] == "-1"
    with pytest.raises(GpsecError, match="closed loop: expected sublanes, found none"):
        resolve_options(config, seed=1, closed_loop=True, lateral_resolution_m=0.0)
