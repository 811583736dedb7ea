"""The last seconds before a crash, by hand."""

import numpy as np
import pytest

from gpsec.outcomes.moments import KEPT_EVERY_S, STORY_S, Crash, LastSeconds, RoadMoment

STEP_S = 0.1


def moment(time_s, serials, x_m, **fields):
    """People who go east in a row at 10 m/s, the first of whom is the fleet's and off by (0, -0.5) m."""
    n = len(serials)
    flags = np.zeros(n, np.bool_)
    fleet = np.arange(n) < 1
    given = {
        "time_s": time_s,
        "serial": np.array(serials, np.int64),
        "x_m": np.array(x_m, np.float64),
        "y_m": np.zeros(n),
        "ux": np.zeros(n),
        "uy": np.ones(n),
        "length_m": np.full(n, 4.5),
        "width_m": np.full(n, 1.8),
        "speed_mps": np.full(n, 10.0),
        "fleet": fleet,
        "lane": np.zeros(n, np.int32),
        "off_m": np.where(fleet[:, None], [[0.0, -0.5]], 0.0),
        "displaced_m": np.where(fleet, 0.4, 0.0),
        "attacked": fleet,
        "alarm": flags,
        "stopped": flags,
    }
    return RoadMoment(**{**given, **fields})


def watched(seconds, serials=(7, 8)):
    """Return who has seen so many seconds in which both went east by 1 m a step."""
    last = LastSeconds(STEP_S)
    for step in range(round(seconds / STEP_S)):
        if last.due(step):
            last.see(moment(step * STEP_S, serials, [step, step + 3.0]))
    return last


def test_a_story_is_the_last_twenty_seconds_of_both_and_the_hit():
    last = watched(60.0)
    last.tell(Crash("oncoming", 9.0, ("a", "b"), (0, 1)), moment(60.0, (7, 8), [600.0, 603.0]))
    rows = last.stories
    mine = [row for row in rows if row["vehicle_id"] == "a"]
    times = [row["time_s"] for row in mine]
    assert times[-1] == 60.0
    assert times[0] == pytest.approx(60.0 - STORY_S, abs=KEPT_EVERY_S + 1e-9)
    assert np.diff(times) == pytest.approx(KEPT_EVERY_S)
    assert {(row["kind"], row["crash_s"], row["closing_mps"]) for row in rows} == {("oncoming", 60.0, 9.0)}
    assert mine[-1]["x_m"] == 600.0
    assert mine[-1]["yaw_rad"] == pytest.approx(np.pi / 2.0)
    assert (mine[-1]["estimate_x_m"], mine[-1]["estimate_y_m"], mine[-1]["displacement_m"]) == (600.0, -0.5, 0.4)
    other = [row for row in rows if row["vehicle_id"] == "b"]
    assert len(other) == len(mine)
    assert other[0]["estimate_x_m"] is other[0]["estimate_y_m"] is None
    assert (mine[0]["attacked"], other[0]["attacked"]) == (True, False)


def test_only_the_first_crash_of_a_kind_is_told():
    last = watched(5.0)
    for kind, name in (("same", "a"), ("same", "c"), ("crossing", "d")):
        last.tell(Crash(kind, 2.0, (name, "b"), (0, 1)), moment(5.0, (7, 8), [50.0, 53.0]))
    assert {(row["kind"], row["vehicle_id"]) for row in last.stories} == {
        ("same", "a"),
        ("same", "b"),
        ("crossing", "d"),
        ("crossing", "b"),
    }


def test_who_was_not_there_has_no_past():
    """Number 9 departs in the moment of the hit: it has one row, and nothing of whoever was at its place before."""
    last = watched(10.0)
    last.tell(Crash("same", 2.0, ("a", "new"), (0, 1)), moment(10.0, (7, 9), [100.0, 103.0]))
    assert sum(row["vehicle_id"] == "new" for row in last.stories) == 1


def test_what_is_held_does_not_grow_with_time():
    assert len(watched(60.0).moments) == len(watched(200.0).moments) == round(STORY_S / KEPT_EVERY_S) + 1
