import re
from math import dist

import libsumo
import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.traffic.names import VehicleNames, numbered_ids
from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession

from .helpers import CAR, ROUTE, TRIP, names


def departures(frames):
    return [(frame.time_s, departure.vehicle_id) for frame in frames for departure in frame.departures]


def spans(frames):
    """First and last step of every vehicle on the road."""
    steps = {}
    for frame, ids in zip(frames, names(frames), strict=True):
        for name in ids:
            steps.setdefault(name, []).append(frame.step)
    return {name: (at[0], at[-1], len(at)) for name, at in steps.items()}


@pytest.mark.parametrize(
    ("vehicle_class", "drives"),
    [(name, True) for name in ("passenger", "taxi", "bus", "truck", "trailer", "emergency", "custom1")]
    + [(name, False) for name in ("bicycle", "moped", "motorcycle", "ignoring")],
)
def test_only_road_vehicles_with_four_wheels_are_candidates(scenario, run, vehicle_class, drives):
    kind = f'<vType id="car" vClass="{vehicle_class}" length="7.5" width="2.25"/>'
    asked = []
    frames, _ = run(scenario(kind + TRIP), equip=lambda departure: asked.append(departure) or True, duration_s=1.0)
    assert frames[-1].on_road == 1
    assert len(frames[-1].rows) == len(asked) == drives
    for departure in asked:
        found = (departure.row, departure.vehicle_id, departure.vehicle_type, departure.vehicle_class)
        assert found == (-1, "v", "car", vehicle_class)
        assert (departure.length_m, departure.width_m) == (7.5, 2.25)


def test_only_whom_equip_takes_gets_a_row_and_it_is_asked_once(scenario, run):
    flow = CAR + '<flow id="f" type="car" begin="0" period="2" number="6" from="A0B0" to="B0C0"/>'
    asked = []

    def equip(departure):
        asked.append(departure.vehicle_id)
        return departure.vehicle_id in {"f.1", "f.4"}

    frames, _ = run(scenario(flow), equip=equip)
    assert sorted(asked) == [f"f.{number}" for number in range(6)]
    assert [name for _, name in departures(frames)] == ["f.1", "f.4"]
    assert max(frame.on_road for frame in frames) == 6


def test_rows_are_the_lowest_that_are_free(scenario, run):
    flow = CAR + '<flow id="f" type="car" begin="0" period="30" number="4" from="A0B0" to="A0B0"/>'
    frames, _ = run(scenario(flow))
    assert [departure.row for frame in frames for departure in frame.departures] == [0, 0, 0, 0]


def test_parking_ends_one_vehicle_and_begins_another(scenario, run):
    stop = '<stop lane="A0B0_0" endPos="100" duration="5" parking="true"/>'
    frames, _ = run(scenario(CAR + f'<vehicle id="v" type="car" depart="0" departPos="0">{ROUTE}{stop}</vehicle>'))
    lives = spans(frames)
    assert list(lives) == ["v", "v#2"]
    away = lives["v#2"][0] - lives["v"][1] - 1
    assert 50 <= away <= 52  # five seconds of ten steps, and the steps in which it leaves the road and comes back


def test_standing_in_the_lane_is_no_parking(scenario, run):
    area = '<parkingArea id="p" lane="A0B0_0" startPos="20" endPos="90" roadsideCapacity="2" onRoad="true"/>'
    stops = '<stop parkingArea="p" duration="5"/><stop lane="A0B0_0" endPos="150" duration="5"/>'
    frames, _ = run(
        scenario(CAR + f'<vehicle id="v" type="car" depart="0" departPos="0">{ROUTE}{stops}</vehicle>', area)
    )
    assert list(spans(frames)) == ["v"]


def test_teleport_ends_one_vehicle_and_begins_another(scenario, run):
    blocks = "".join(
        f'<vehicle id="b{lane}" type="car" depart="0" departLane="{lane}" departPos="150">{ROUTE}'
        f'<stop lane="A0B0_{lane}" endPos="180" duration="60"/></vehicle>'
        for lane in (0, 1)
    )
    victim = f'<vehicle id="v" type="car" depart="0" departPos="20">{ROUTE}</vehicle>'
    config = scenario(CAR + blocks + victim, options='<time-to-teleport value="5"/>')
    frames, session = run(config, equip=lambda departure: departure.vehicle_id == "v", duration_s=90.0)
    lives = spans(frames)
    assert list(lives) == ["v", "v#2"]
    assert any("Teleporting vehicle 'v'" in warning for warning in session.warnings)


def test_vehicle_that_leaves_the_map_comes_back_as_another(scenario, run, lane_index):
    known = {lane: at for lane, at in lane_index.items() if not lane.startswith(":")}
    frames, _ = run(scenario(), lanes=known)
    lives = spans(frames)
    assert list(lives) == ["v", "v#2"]
    assert lives["v#2"][0] > lives["v"][1] + 1
    assert all(lane in known.values() for frame in frames for lane in frame.lane)


def test_jump_ends_one_vehicle_and_begins_another_in_the_same_step(scenario, lane_index):
    options = resolve_options(scenario(), seed=1)
    frames = []
    with SumoSession(options, lane_index, lambda departure: True) as session:
        for frame in session.frames(2.0):
            frames.append(frame)
            if frame.step == 9:
                libsumo.vehicle.moveTo("v", "A0B0_0", 120.0)
    jump = next(frame for frame in frames if frame.left)
    assert spans(frames) == {"v": (0, jump.step - 1, jump.step), "v#2": (jump.step, 19, 20 - jump.step)}
    assert jump.step in (10, 11)
    assert jump.left == [departure.row for departure in jump.departures] == [0]


@pytest.mark.parametrize("share", [0.3, 1.0, 3.0])
def test_driving_along_a_lane_with_another_length_than_its_shape_is_no_jump(scenario, run, share):
    """SUMO maps positions along the length onto the shape: a tenth of a third of it is a tenth of the shape."""
    config = scenario('<vType id="car" sigma="0"/>' + TRIP)
    net = config.with_name("grid.net.xml")
    text = net.read_text()
    (length,) = set(re.findall(r'<lane id="A0B0_\d"[^>]* length="([\d.]+)"', text))
    shorter = rf'\g<1>{float(length) * share:.2f}"'
    net.write_text(re.sub(r'(<lane id="A0B0_\d"[^>]* length=")[\d.]+"', shorter, text))
    frames, _ = run(config)
    assert list(spans(frames)) == ["v"]
    steps = [frame for frame in frames if len(frame.rows)]
    way = np.hypot(*np.diff(np.concatenate([frame.front_m for frame in steps]), axis=0).T)
    assert way.sum() == pytest.approx(400.0, abs=40.0)  # it departs with its rear at the beginning
    assert (way.max() > 2.0) == (share < 1.0)


def test_driving_at_any_speed_is_no_jump(scenario, run):
    kind = '<vType id="car" maxSpeed="50" speedFactor="normc(3,0,1,4)" accel="9" decel="9"/>'
    frames, _ = run(scenario(kind + TRIP), step_s=0.2)
    assert list(spans(frames)) == ["v"]
    way = np.concatenate([frame.front_m for frame in frames])
    assert np.hypot(*np.diff(way, axis=0).T).max() / 0.2 > 25.0


def test_jumps_are_the_moves_that_are_longer_than_the_speed_allows(scenario, lane_index):
    """By the speed that every vehicle has in every step, which the roster asks of few."""
    kind = '<vType id="car" sigma="0.5" speedFactor="norm(1,0.3)"/>'
    flow = '<flow id="f" type="car" begin="0" end="60" period="2" departLane="random" departSpeed="max" '
    config = scenario(kind + flow + 'from="A0B0" to="B2C2"/>' + flow.replace('"f"', '"g"') + 'from="C2B2" to="B0A0"/>')
    options = resolve_options(config, seed=1, lateral_resolution_m=0.0)
    jumps, expected, last = [], [], {}
    with SumoSession(options, lane_index, lambda departure: True) as session:
        for frame in session.frames(80.0):
            jumps += [(frame.step, d.vehicle_id.split("#")[0]) for d in frame.departures if "#" in d.vehicle_id]
            now = {
                name: (libsumo.vehicle.getPosition(name), libsumo.vehicle.getSpeed(name))
                for name in libsumo.vehicle.getIDList()
            }
            for name in sorted(now.keys() & last.keys()):
                (place, speed), (before, speed_before) = now[name], last[name]
                if dist(place, before) > max(speed, speed_before) * 0.1 + 1.0:
                    expected.append((frame.step, name))
            last = now
    assert sorted(jumps) == sorted(expected)
    assert len(jumps) > 20  # SUMO changes lanes in one step here


def test_vehicle_that_is_taken_out_leaves_its_row(scenario, lane_index):
    flow = CAR + '<flow id="f" type="car" begin="0" period="1" number="3" from="A0B0" to="B0C0"/>'
    frames = []
    with SumoSession(resolve_options(scenario(flow), seed=1), lane_index, lambda departure: True) as session:
        for frame in session.frames(6.0):
            frames.append(frame)
            if frame.step == 40:
                libsumo.vehicle.remove("f.1")
    lives = spans(frames)
    assert lives["f.1"][1] in (40, 41)
    assert lives["f.0"][1] == lives["f.2"][1] == 59


def test_vehicle_that_is_taken_out_while_it_parks_does_not_come_back(scenario, lane_index):
    stop = '<stop lane="A0B0_0" endPos="50" duration="60" parking="true"/>'
    routes = CAR + f'<vehicle id="v" type="car" depart="0" departPos="0">{ROUTE}{stop}</vehicle>'
    frames = []
    with SumoSession(resolve_options(scenario(routes), seed=1), lane_index, lambda departure: True) as session:
        for frame in session.frames(60.0):
            frames.append(frame)
            if frame.step == 200:
                assert libsumo.vehicle.isStoppedParking("v")
                libsumo.vehicle.remove("v")
    assert list(spans(frames)) == ["v"]


def test_more_vehicles_than_there_was_room_for(scenario, run):
    edges = [f"{a}{n}{b}{n}" for n in range(3) for a, b in ("AB", "BC", "BA", "CB")]
    edges += [f"{a}{n}{a}{m}" for a in "ABC" for n, m in ((0, 1), (1, 2), (1, 0), (2, 1))]
    flows = "".join(
        f'<flow id="{edge}" type="car" begin="0" end="20" period="1" departPos="random_free" departLane="random" '
        f'departSpeed="0" from="{edge}" to="{edge}"/>'
        for edge in edges
    )
    frames, _ = run(scenario(CAR + flows), duration_s=21.0)
    assert max(len(frame.rows) for frame in frames) > 256
    assert all(len(ids) == len(set(ids)) for ids in names(frames))


def test_type_parameters_reach_the_departure(scenario, run):
    own = '<param key="gpsec.equipped" value="0.25"/><param key="gpsec.sensors" value="carla"/>'
    kinds = f'<vType id="own">{own}</vType><vType id="plain"/>'
    trips = "".join(f'<vehicle id="{name}" type="{name}" depart="0">{ROUTE}</vehicle>' for name in ("own", "plain"))
    frames, _ = run(scenario(kinds + trips), duration_s=5.0)
    found = {d.vehicle_id: (d.equipped_share, d.sensors) for frame in frames for d in frame.departures}
    assert found == {"own": (0.25, "carla"), "plain": (None, None)}


@pytest.mark.parametrize("share", ["1.5", "-0.1", "half", "nan"])
def test_equipped_that_is_no_probability_names_type_and_key(scenario, run, share):
    kind = f'<vType id="car"><param key="gpsec.equipped" value="{share}"/></vType>'
    message = f"vType 'car': parameter 'gpsec.equipped': expected a probability from 0 to 1, found '{share}'"
    with pytest.raises(GpsecError, match=message):
        run(scenario(kind + TRIP), duration_s=1.0)
    assert not libsumo.isLoaded()


def test_unknown_type_parameter_is_refused_with_the_nearest(scenario, run):
    kind = '<vType id="car"><param key="gpsec.equiped" value="1"/></vType>'
    with pytest.raises(GpsecError, match=r"cars.rou.xml: vType 'car': .* did you mean 'gpsec.equipped'"):
        run(scenario(kind + TRIP))


PARKING = '<stop lane="A0B0_0" endPos="100" duration="5" parking="true"/>'


def parked(name, depart, stop=PARKING):
    return f'<vehicle id="{name}" type="car" depart="{depart}" departPos="0">{ROUTE}{stop}</vehicle>'


def ids_of(frames):
    return {departure.vehicle_id: departure.sumo_id for frame in frames for departure in frame.departures}


def test_no_two_vehicles_have_one_name_whatever_sumo_calls_them(scenario, run):
    """SUMO's own v#2 departs long after v has come back from its stay."""
    frames, _ = run(scenario(CAR + parked("v", 0) + parked("v#3", 1) + parked("v#2", 40, "")))
    names_given = [name for _, name in departures(frames)]
    assert sorted(names_given) == ["v", "v#2", "v#3", "v#3#2", "v#4"]
    assert ids_of(frames) == {"v": "v", "v#2": "v#2", "v#3": "v#3", "v#3#2": "v#3", "v#4": "v"}


def test_an_id_that_comes_back_is_another_vehicle(scenario, run):
    """SUMO takes an id again once it is free; it reads ten seconds ahead here, and the next vehicle after that."""
    gone = '<vehicle id="{}" type="car" depart="{}" departPos="150" departSpeed="max"><route edges="A0B0"/></vehicle>'
    each = "".join(gone.format(name, depart) for name, depart in (("v", 0), ("w", 20), ("v", 40), ("x", 60), ("v", 80)))
    frames, _ = run(scenario(CAR + each, options='<processing><route-steps value="10"/></processing>'))
    assert [name for _, name in departures(frames)] == ["v", "w", "v#2", "x", "v#3"]
    assert set(ids_of(frames).values()) == {"v", "w", "x"}


def test_numbered_ids_are_found_in_included_files(tmp_path):
    (tmp_path / "inner.xml").write_text("<routes><vehicle depart='3' id='a&amp;b#12'/></routes>")
    (tmp_path / "outer.xml").write_text('<routes><include href="inner.xml"/><vehicle id="c#x"/></routes>')
    assert numbered_ids([tmp_path / "outer.xml"]) == {"a&b#12"}


def test_names_stay_unique_where_an_id_was_not_foreseen():
    given = VehicleNames()
    assert [given.give(name) for name in ("p", "p", "p#2", "p", "p#2")] == ["p", "p#2", "p#2#2", "p#3", "p#2#3"]
