"""What a run shows in sumo-gui, and that showing it changes nothing."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gpsec.console.run import live_run
from gpsec.core.errors import GpsecError
from gpsec.core.tables import Table
from gpsec.outcomes.state import OUT_OF_LANE, OutcomeState
from gpsec.outcomes.study import Study
from gpsec.pipeline.live import (
    CLEAN,
    FALSE_ALARM,
    SEEN,
    STRAYED,
    UNSEEN,
    Live,
    LiveRun,
    body_outline,
    choose_defence,
    choose_plan,
    chosen_tracks,
    track_states,
)
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario
from gpsec.scenario.closed_loop import ClosedWorld
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

STUDY = Study(
    ("none", "drift", "noise"),
    ("never", "cusum", "lstm_glr"),
    ("", "0.1/h", "0.1/h"),
    ("fixed", "counted", "counted"),
    (("never", "none"), ("cusum", "ukf"), ("lstm_glr", "ukf"), ("lstm_glr", "none")),
    ("carla",),
    np.zeros((1, 3)),
    0.1,
)


def test_each_vehicle_is_shown_once_under_the_chosen_plan_where_that_has_begun():
    tracks = Table(Tracks, 6).now
    tracks.vehicle[:] = [0, 1, 1, 3, 3, 0]
    tracks.plan[:] = [0, 0, 2, 0, 1, 2]
    rows = np.arange(5, dtype=np.int32)  # the last is not in use
    assert chosen_tracks(rows, tracks, 2).tolist() == [0, 2, 3]
    assert chosen_tracks(rows, tracks, 1).tolist() == [0, 1, 4]
    assert chosen_tracks(rows[:0], tracks, 1).tolist() == []


@pytest.mark.parametrize(
    ("attacked", "detected", "in_alarm", "left", "state"),
    [
        (False, False, False, False, CLEAN),
        (False, False, True, False, FALSE_ALARM),
        (False, True, False, False, CLEAN),  # the attack is over
        (False, True, True, False, FALSE_ALARM),
        (True, False, False, False, UNSEEN),
        (True, True, False, False, SEEN),  # once seen is seen
        (True, True, True, False, SEEN),
        (True, True, True, True, STRAYED),
        (False, False, False, True, STRAYED),
    ],
)
def test_the_state_of_a_track(attacked, detected, in_alarm, left, state):
    tracks, outcomes = Table(Tracks, 3).now, Table(OutcomeState, 3, detectors=2, defences=2).now
    tracks.attacked[1] = attacked
    outcomes.detection_step[1, 0] = 7 if detected else -1
    outcomes.in_alarm[1, 0] = in_alarm
    outcomes.first_step[1, 1, OUT_OF_LANE] = 9 if left else -1
    # What another detector, another defence and other tracks say does not count.
    outcomes.detection_step[:, 1] = 3
    outcomes.in_alarm[:, 1] = True
    outcomes.first_step[:, 0] = 3
    outcomes.first_step[0] = 3
    assert track_states(np.array([1], np.int32), tracks, outcomes, 1, 0).tolist() == [state]


def test_a_ghost_is_the_body_around_the_believed_axle():
    vehicles = Table(Vehicles, 2).now
    vehicles.axle_m[1], vehicles.length_m[1], vehicles.width_m[1] = 4.0, 5.0, 2.0
    vehicles.yaw_rad[1] = np.pi / 2  # north: ahead is +y, left is -x
    vehicles.speed_mps[1] = 20.0  # 2 m in a step
    corners = [(9.0, 19.0), (11.0, 19.0), (11.0, 23.0), (10.0, 24.0), (9.0, 23.0)]
    np.testing.assert_allclose(body_outline(np.array([10.0, 20.0]), vehicles, 1, 0.0), corners, atol=1e-12)
    np.testing.assert_allclose(body_outline(np.array([10.0, 18.0]), vehicles, 1, 0.1), corners, atol=1e-12)


def test_plan_and_defence_have_sensible_defaults():
    assert (choose_plan(STUDY, None), choose_plan(STUDY, "noise")) == (1, 2)
    assert (choose_defence(STUDY, None), choose_defence(STUDY, "cusum+ukf")) == (2, 1)
    with pytest.raises(GpsecError, match=r"unknown plan 'drif'; did you mean 'drift'\?"):
        choose_plan(STUDY, "drif")
    with pytest.raises(GpsecError, match="unknown plan 'none'"):
        choose_plan(STUDY, "none")
    with pytest.raises(GpsecError, match=r"unknown defence 'lstm_glr'.*known: cusum\+ukf"):
        choose_defence(STUDY, "lstm_glr")


def test_what_cannot_be_shown_is_said_in_a_sentence(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":5")
    assert live_run(["a"], False, None, None, None) is None
    assert live_run(["a"], True, "drift", None, 0.0) == LiveRun("drift", None, 0.0)
    with pytest.raises(GpsecError, match="--gui: expected one scenario, found 2"):
        live_run(["a", "b"], True, None, None, None)
    with pytest.raises(GpsecError, match=r"--gui-delay 3\.0: expected --gui with it"):
        live_run(["a"], False, None, None, 3.0)
    monkeypatch.delenv("DISPLAY")
    with pytest.raises(GpsecError, match="expected a display"):
        live_run(["a"], True, None, None, None)


@pytest.fixture
def display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    if shutil.which("Xvfb") is None:
        pytest.skip("not on this machine: Xvfb")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "640x480x24", "+extension", "GLX"]
    with subprocess.Popen(command, pass_fds=(write,), stderr=subprocess.DEVNULL) as screen, os.fdopen(read) as number:
        os.close(write)
        monkeypatch.setenv("DISPLAY", f":{number.readline().strip()}")
        monkeypatch.setenv("LIBGL_ALWAYS_SOFTWARE", "1")
        monkeypatch.setenv("HOME", str(tmp_path))
        yield
        screen.kill()


class Stopping(Live):
    """Closes the window with a key after some steps, as a user does."""

    def see(self, view, outcomes, fleet):
        super().see(view, outcomes, fleet)
        if view.step == 20:
            windows = subprocess.run(
                ["xdotool", "search", "--name", "SUMO"], capture_output=True, text=True, check=True
            )
            window = windows.stdout.split()[-1]
            subprocess.run(["xdotool", "windowfocus", window, "mousemove", "300", "300"], check=True)
            subprocess.run(["xdotool", "key", "ctrl+q"], check=True)


def short(town: Scenario) -> Scenario:
    return town.model_copy(update={"duration_s": 40.0})


def test_the_tables_are_the_same_bytes_with_and_without_a_window(town, tmp_path, display):
    with_window, without = tmp_path / "with", tmp_path / "without"
    looks = []

    class Counting(Live):
        def see(self, view, outcomes, fleet):
            super().see(view, outcomes, fleet)
            looks.append(self._session.look)

    for folder in (with_window, without):
        folder.mkdir()
    live = Counting(None, None, 0.0)
    run_scenario(short(town), with_window, lambda progress: None, live.start, onlooker=live)
    run_scenario(short(town), without, lambda progress: None)
    tables = sorted(path.name for path in without.glob("*.csv"))
    assert len(tables) > 5
    for name in tables:
        assert (with_window / name).read_bytes() == (without / name).read_bytes(), name
    assert len(looks) == 400
    assert any(look.ghost and look.followed for look in looks)
    assert len({colour for look in looks for _, colour in look.colours}) >= 3


def test_a_closed_world_is_the_same_with_a_window_in_which_displaced_vehicles_are_drawn(town, tmp_path, display):
    """Some are elsewhere than SUMO has them: near junctions it keeps them to their lane."""
    section = town.closed_loop.model_copy(update={"world": ClosedWorld(plan=town.plans[0].name)})
    world = short(town).model_copy(update={"closed_loop": section, "plans": town.plans[:1]})
    with_window, without = tmp_path / "with", tmp_path / "without"
    looks = []

    class Counting(Live):
        def see(self, view, outcomes, fleet):
            super().see(view, outcomes, fleet)
            looks.append(self._session.look)

    for folder in (with_window, without):
        folder.mkdir()
    live = Counting(None, None, 0.0, controlled=True)
    run_scenario(world, with_window, lambda progress: None, live.start, onlooker=live, takes_commands=True)
    run_scenario(world, without, lambda progress: None)
    for name in ("worlds", "events", "collisions", "crashes", "vehicles"):
        assert (with_window / f"{name}.csv").read_bytes() == (without / f"{name}.csv").read_bytes(), name
    drawn = [body for look in looks for body in look.bodies]
    assert len({name for name, _, _ in drawn}) >= 1


def test_closing_the_window_interrupts_the_run(town, tmp_path, display):
    if shutil.which("xdotool") is None:
        pytest.skip("not on this machine: xdotool")
    live = Stopping(None, None, 0.0)
    with pytest.raises(KeyboardInterrupt):
        run_scenario(short(town), tmp_path, lambda progress: None, live.start, onlooker=live)


def test_a_display_that_is_not_there_is_said_in_a_sentence(town, tmp_path, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":4711")
    live = Live(None, None, 0.0)
    with pytest.raises(GpsecError, match="could not open its window on the display ':4711'"):
        run_scenario(short(town), tmp_path, lambda progress: None, live.start, onlooker=live)
