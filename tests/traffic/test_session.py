import subprocess
from pathlib import Path
from xml.etree import ElementTree

import libsumo
import numpy as np
import pytest
import sumo

from gpsec.core.errors import GpsecError
from gpsec.core.geo import yaw_from_sumo_angle
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import record_traffic
from gpsec.traffic.session import SumoSession

from .helpers import CAR, ROUTE, TRIP, listing, names

GAME = Path(sumo.SUMO_HOME) / "tools" / "game"
FLOWS = (
    CAR
    + '<flow id="f" type="car" begin="0" end="40" period="2" from="A0B0" to="B2C2"/>'
    + '<flow id="g" type="car" begin="0" end="40" period="3" from="C2B2" to="B0A0"/>'
)


def test_frames_are_what_sumo_itself_writes_as_floating_car_data(scenario, run, tmp_path, lane_index):
    config = scenario(FLOWS)
    frames, _ = run(config, duration_s=60.0)
    out = tmp_path / "fcd.xml"
    arguments = resolve_options(config, seed=1).arguments
    command = [Path(sumo.SUMO_HOME) / "bin" / "sumo", *arguments, "--fcd-output", out, "--precision", "9"]
    subprocess.run([*command, "--end", "60"], check=True, capture_output=True)
    # SUMO writes the state at the beginning of a step, libsumo gives it after the step before.
    written = {round(float(step.get("time")), 3): step for step in ElementTree.parse(out).getroot()}
    compared = 0
    for frame, ids in zip(frames, names(frames), strict=True):
        step = written.get(round(frame.time_s - 0.1, 3))
        assert step is not None
        vehicles = {vehicle.get("id"): vehicle for vehicle in step}
        assert set(vehicles) == set(ids)
        assert frame.on_road == len(vehicles)
        for at, name in enumerate(ids):
            vehicle = vehicles[name]
            expected = [float(vehicle.get(key)) for key in ("x", "y")]
            np.testing.assert_allclose(frame.front_m[at], expected, atol=1e-8)
            assert frame.lane[at] == lane_index[vehicle.get("lane")]
            compared += 1
        for departure in frame.departures:
            angle, speed = (float(vehicles[departure.vehicle_id].get(key)) for key in ("angle", "speed"))
            assert departure.yaw_rad == pytest.approx(yaw_from_sumo_angle(angle), abs=1e-8)
            assert departure.speed_mps == pytest.approx(speed, abs=1e-8)
    assert compared > 5000


def test_same_seed_same_bytes_and_another_seed_another_traffic(scenario, lane_index):
    config = scenario(FLOWS)
    recordings = []
    for seed in (1, 1, 2):
        with SumoSession(resolve_options(config, seed=seed), lane_index, lambda departure: True) as session:
            recordings.append(record_traffic(session, 30.0))
    first, second, third = (recording.front_m.tobytes() for recording in recordings)
    assert first == second
    assert first != third


def test_nothing_is_written_beside_the_scenario_or_printed(scenario, run, capfd, monkeypatch, tmp_path):
    folder = tmp_path / "scenario"
    car = (
        '<vType id="car"><param key="has.ssm.device" value="true"/><param key="device.ssm.file" value="s.xml"/></vType>'
    )
    outputs = ["e1.xml", "sub/e1.xml", str(folder / "absolute.xml"), "../outside.xml", "NUL"]
    detectors = "".join(
        f'<e1Detector id="d{at}" lane="A0B0_0" pos="5" period="1" file="{file}"/>' for at, file in enumerate(outputs)
    )
    extra = '<edgeData id="e" file="edges.xml.gz" period="1"/>'
    options = (
        '<output><tripinfo-output value="trips.xml"/><summary value="summary.xml"/><save-state.times value="1"/>'
        '</output><report><verbose value="true"/><log value="log.txt"/><error-log value="e.txt"/></report>'
    )
    config = scenario(car + TRIP, detectors + extra, options)
    (folder / "sub").mkdir()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    before = listing(tmp_path)
    capfd.readouterr()
    with SumoSession(resolve_options(config, seed=1), {}, lambda departure: False) as session:
        assert len(list(session.frames(5.0))) == 50
        [temporary] = Path(libsumo.simulation.getOption("error-log")).parents[:1]
        assert {"e1.xml", "absolute.xml", "outside.xml", "edges.xml.gz"} <= {file.name for file in temporary.iterdir()}
    assert capfd.readouterr() == ("", "")
    assert listing(tmp_path) == before
    assert not temporary.exists()
    assert any("No measures specified for ssm device" in warning for warning in session.warnings)


WHEEL = ("A10KW", "bs3d", "cross", "square", "ramp", "corridor", "grid6", "fkk_in", "racing/racing")


@pytest.mark.parametrize("name", [*(f"{name}.sumocfg" for name in WHEEL), "highway.sumocfg.disabled"])
def test_scenarios_of_the_wheel_run_and_stay_as_they_were(name, run):
    before = listing(GAME)
    config = GAME / name
    options = resolve_options(config, seed=3)
    with SumoSession(options, {}, lambda departure: True) as session:
        frames = list(session.frames(30.0))
        assert libsumo.simulation.getOption("lateral-resolution") == "0.8"
    assert len(frames) == 300
    assert frames[-1].time_s == pytest.approx(options.begin_s + 30.0)
    assert max(frame.on_road for frame in frames) > 0
    assert listing(GAME) == before


@pytest.mark.parametrize(
    ("options", "duration_s", "steps"),
    [
        ('<begin value="10"/><end value="12"/>', None, 20),
        ('<begin value="10"/><end value="12"/>', 0.5, 5),
        ('<begin value="10"/><end value="12"/>', 60.0, 20),
        ('<begin value="10"/><end value="12"/><step-length value="0.05"/>', None, 40),
        ('<begin value="10"/>', 0.3, 3),  # 0.3 / 0.1 is a little less than 3 in binary
        ("", 0.0, 0),
        # Nobody departs in the first five seconds; they count from the departure at 10 s, in step 100.
        ("", 5.0, 150),
        ('<end value="12"/>', 5.0, 120),
    ],
)
def test_run_ends_at_the_scenarios_end_or_after_the_duration(scenario, run, options, duration_s, steps):
    config = scenario(CAR + f'<vehicle id="v" type="car" depart="10">{ROUTE}</vehicle>', options=options)
    frames, _ = run(config, duration_s=duration_s)
    assert [frame.step for frame in frames] == list(range(steps))


def test_run_ends_when_the_last_vehicle_has_arrived(scenario, run):
    frames, _ = run(scenario(), duration_s=3600.0)
    assert frames[-1].time_s < 120.0
    assert frames[-1].left == [0]
    assert frames[-1].on_road == len(frames[-1].rows) == 0


def test_times_spent_in_sumo_and_in_reading_are_kept_apart(scenario, run):
    _, session = run(scenario(FLOWS), duration_s=5.0)
    assert session.sumo_s > 0.0
    assert session.read_s > 0.0


def test_a_second_session_is_refused_until_the_first_is_closed(scenario, lane_index):
    options = resolve_options(scenario(), seed=1)
    message = "open in this process already"
    with SumoSession(options, lane_index, lambda departure: True), pytest.raises(GpsecError, match=message):
        SumoSession(options, lane_index, lambda departure: True)
    with SumoSession(options, lane_index, lambda departure: True) as again:
        assert len(list(again.frames(1.0))) == 10
        again.close()
        again.close()


@pytest.mark.parametrize(
    ("routes", "additional", "words"),
    [
        (
            '<vehicle id="q" depart="1"><route edges="A0B0 nowhere"/></vehicle>',
            "",
            "The edge 'nowhere' within the route",
        ),
        ('<vehicle id="q" depart="1"><route edges="A0B0 C2C1"/></vehicle>', "", "No connection between edge 'A0B0'"),
        ('<vehicle id="q" type="ghost" depart="1"><route edges="A0B0"/></vehicle>', "", "'ghost'"),
        ("<vehicle id=", "", "In file '.*cars.rou.xml' At line/column 2/"),
        ("", '<e1Detector id="d" lane="none_0" pos="1" period="9" file="x"/>', "'none_0' is not known"),
        ("", "<poly", "In file '.*more.add.xml' At line/column"),
    ],
)
def test_sumos_errors_come_in_its_words_and_leave_no_simulation(scenario, run, capfd, routes, additional, words):
    config = scenario(routes, additional)
    with pytest.raises(GpsecError, match=f"SUMO says: .*{words}") as raised:
        run(config, duration_s=3.0)
    assert str(raised.value).startswith(str(config))
    assert "\n" not in str(raised.value)
    assert capfd.readouterr() == ("", "")
    assert not libsumo.isLoaded()


def test_broken_net_is_told_in_sumos_words(scenario, run):
    config = scenario()
    net = config.parent / "grid.net.xml"
    net.write_text(net.read_text()[:20000])
    with pytest.raises(GpsecError, match=r"SUMO says: .* In file '.*grid.net.xml' At line/column"):
        run(config)
