import os
import signal
import time
from multiprocessing import active_children, get_context
from pathlib import Path

import numpy as np
import pytest

from gpsec.attacks.zones import zone_keys
from gpsec.core.errors import GpsecError, MachineError
from gpsec.traffic import remote
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import record_traffic
from gpsec.traffic.remote import RemoteSession
from gpsec.traffic.ring import Head
from gpsec.traffic.session import SumoSession
from gpsec.traffic.source import Frame
from gpsec.types.drawn_zones import ATTACK_ZONE

from .helpers import CAR, listing

FLOWS = (
    CAR
    + '<flow id="f" type="car" begin="0" end="40" period="2" from="A0B0" to="B2C2"/>'
    + '<flow id="g" type="car" begin="0" end="40" period="3" from="C2B2" to="B0A0"/>'
    + '<vType id="van" vClass="delivery"><param key="gpsec.attack" value="drift"/></vType>'
    + '<trip id="s" type="van" depart="7" from="A0B0" to="B2C2"/>'
    + '<vType id="bike" vClass="bicycle"/>'
    + '<flow id="b" type="bike" begin="8" end="20" number="2" from="A0B0" to="B2C2"/>'
)
ZONE = (
    '<poly id="z" type="gpsec.attack" shape="0,0 9,0 9,9"><param key="gpsec.attack" value="jamming"/></poly>'
    '<poi id="p" type="gpsec.attack" x="1" y="2"><param key="gpsec.attack" value="drift"/></poi>'
)


def everybody(departure):
    return True


def nobody_called_f(departure):
    return not departure.vehicle_id.startswith("f")


@pytest.mark.parametrize("capacity", [32_768, 3], ids=["ring", "overflow"])
@pytest.mark.parametrize("equip", [everybody, nobody_called_f])
def test_frames_are_those_of_the_session_to_the_byte(scenario, lane_index, equip, capacity):
    options = resolve_options(scenario(FLOWS), seed=3)
    with SumoSession(options, lane_index, equip) as session:
        here = record_traffic(session, 50.0)
        others = session.traffic_only
    with RemoteSession(options, lane_index, equip, capacity) as session:
        there = record_traffic(session, 50.0)
        assert session.sumo_s > 0.0
        assert session.read_s > 0.0
        assert session.traffic_only == others == {"bicycle": 2}
    for name, array in vars(here).items():
        np.testing.assert_array_equal(array, getattr(there, name), err_msg=name, strict=True)
    assert max(np.diff(here.start)) > 3
    assert set(here.spoofer_plan.tolist()) == {"van"}


def test_a_reader_may_be_slower_than_the_simulation(scenario, lane_index):
    options = resolve_options(scenario(FLOWS), seed=3)
    with RemoteSession(options, lane_index, everybody) as session:
        steps = []
        for frame in session.frames(0.3):
            # Time to simulate all of it before the first step is taken up.
            time.sleep(0.0 if steps else 0.5)
            steps.append(frame.step)
    assert steps == [0, 1, 2]
    assert session.exit_code == 0


def test_zones_come_over(scenario, lane_index):
    options = resolve_options(scenario(FLOWS, ZONE), seed=1)
    with RemoteSession(options, lane_index, everybody) as session:
        zones = session.zones({ATTACK_ZONE: zone_keys()})
        assert [(zone.zone_id, zone.kind, zone.parameters["gpsec.attack"]) for zone in zones] == [
            ("z", "polygon", "jamming"),
            ("p", "point", "drift"),
        ]
        assert len(list(session.frames(1.0))) == 10


def test_what_sumo_refuses_comes_in_its_words(scenario, lane_index):
    broken = CAR + '<vehicle id="v" type="car" depart="0"><route edges="A0B0 nowhere"/></vehicle>'
    options = resolve_options(scenario(broken), seed=1)
    with pytest.raises(GpsecError, match="nowhere"), RemoteSession(options, lane_index, everybody) as session:
        list(session.frames(5.0))


def test_what_sumo_refuses_later_comes_in_its_words_too(scenario, lane_index):
    late = CAR + "".join(
        f'<vehicle id="v{number}" type="{"nope" if number == 20 else "car"}" depart="{0.3 * number:.1f}">'
        '<route edges="A0B0 B0C0"/></vehicle>'
        for number in range(21)
    )
    options = resolve_options(scenario(late), seed=1)
    with RemoteSession(options, lane_index, everybody) as session:
        frames = session.frames(20.0)
        assert next(frames).step == 0
        with pytest.raises(GpsecError, match="The vehicle type 'nope' for vehicle 'v20' is not known") as caught:
            list(frames)
    assert caught.value.status == 2
    assert session.exit_code == 0


def says_why_and_is_gone(connection, *others):
    """Stands in for SUMO's process: it is some steps ahead when it gives up, and does not wait for its reader."""
    connection.send(0.1)
    connection.recv()
    empty = np.zeros(0, np.int32)
    for step in range(3):
        frame = Frame(step, 0.1 * step, [], [], empty, np.zeros((0, 2)), empty, 0, {})
        connection.send(Head(frame, None, 0.0, 0.0))
    connection.send(GpsecError("run.sumocfg: SUMO says: why"))


def test_what_was_said_before_the_end_is_read(scenario, lane_index, monkeypatch):
    monkeypatch.setattr(remote, "serve", says_why_and_is_gone)
    session = RemoteSession(resolve_options(scenario(FLOWS), seed=1), lane_index, everybody)
    with session:
        frames = session.frames()
        assert next(frames).step == 0
        for process in active_children():
            process.join()  # from now on nobody takes what we send
        assert [next(frames).step, next(frames).step] == [1, 2]
        with pytest.raises(GpsecError, match="SUMO says: why"):
            next(frames)


def test_closing_early_ends_the_process_and_writes_nothing(scenario, lane_index, tmp_path):
    config = scenario(FLOWS)
    before = listing(tmp_path)
    session = RemoteSession(resolve_options(config, seed=1), lane_index, everybody)
    frames = session.frames(None)
    next(frames)
    session.close()
    session.close()
    assert session.exit_code is not None
    assert listing(tmp_path) == before


def test_a_dead_simulation_is_said(scenario, lane_index, monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # who is killed cannot clean up
    with RemoteSession(resolve_options(scenario(FLOWS), seed=1), lane_index, everybody) as session:
        frames = session.frames(None)
        next(frames)
        os.kill(session.process_id, signal.SIGKILL)
        with pytest.raises(MachineError, match=r"run\.sumocfg: the process of SUMO ended early \(SIGKILL: .*memory\)"):
            list(frames)


def die_in_the_middle(config: Path, lanes: dict[str, int], told) -> None:
    session = RemoteSession(resolve_options(config, seed=1), lanes, everybody)
    next(session.frames(None))
    told.send(session.process_id)
    os.kill(os.getpid(), signal.SIGKILL)


def test_the_simulation_ends_when_the_evaluator_is_killed(scenario, lane_index, monkeypatch, tmp_path):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=die_in_the_middle, args=(scenario(FLOWS), lane_index, theirs))
    process.start()
    simulation = ours.recv()
    process.join()
    # The orphan's pipe is closed; nobody is left to reap it but the system, so look for it.
    for _ in range(200):
        if not alive(simulation):
            assert not list(folder.glob("gpsec-sumo-*"))
            return
        time.sleep(0.05)
    pytest.fail("the process of SUMO is still there")


def alive(process_id: int) -> bool:
    try:
        state = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
