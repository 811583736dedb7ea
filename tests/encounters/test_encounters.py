"""Hits, wrecks, critical moments and drivers, with numbers by hand."""

import numpy as np
import pytest

from gpsec.encounters.encounters import EncounterRules, Encounters, People
from gpsec.encounters.meeting import Kind

from .scene import bodies

RULES = EncounterRules(step_s=0.1, oncoming_reaction_s=0.5, wreck_s=2.0)


def people(*cars, driven=(), astray=(), number=None):
    everybody = range(len(cars))
    return People(
        np.array(everybody if number is None else number, np.int32),
        bodies(*cars),
        np.array([k in driven for k in everybody]),
        np.array([k in astray for k in everybody]),
    )


def drive(steps, begin, scene):
    """Let a scene, a function of the seconds, go on; yield (step, what it met)."""
    encounters = Encounters(RULES)
    for step in range(steps):
        yield step, encounters.update(begin + step, scene(0.1 * step))


def head_on(seconds, **who):
    """30 m apart at 40 m/s of closing speed, 4 m long each: contact after 26/40 = 0.65 s."""
    return people((20.0 * seconds, 0.0, 0.0, 20.0), (30.0 - 20.0 * seconds, 0.3, 180.0, 20.0), **who)


def test_a_head_on_crash_at_40_mps_is_reported_within_a_step_and_once():
    met = list(drive(10, 7, lambda s: head_on(s, driven=[0], astray=[0])))
    hits = [(step, one.hits) for step, one in met if len(one.hits.first)]
    assert [step for step, _ in hits] == [7]
    assert hits[0][1].kind.tolist() == [Kind.ONCOMING]
    assert hits[0][1].closing_mps[0] == pytest.approx(40.0)
    assert met[6][1].wrecked.tolist() == [False, False]
    assert met[7][1].wrecked.tolist() == [True, True]


def test_what_sumo_does_by_itself_is_no_encounter():
    met = list(drive(10, 0, head_on))
    assert all(len(one.hits.first) == one.critical_ttc == one.critical_drac == 0 for _, one in met)


def test_a_wreck_expires_and_who_hits_it_is_counted_as_that():
    def scene(seconds):
        return people(
            (0.0, 0.0, 0.0, 0.0), (3.9, 0.0, 0.0, 0.0), (-19.05 + 20.0 * seconds, 0.0, 0.0, 20.0), number=[5, 2, 9]
        )

    encounters = Encounters(RULES)
    crash = people((0.0, 0.0, 0.0, 5.0), (3.9, 0.0, 0.0, 0.0), driven=[0], number=[5, 2])
    assert encounters.update(0, crash).hits.kind.tolist() == [Kind.SAME]
    met = [encounters.update(step, scene(0.1 * step)) for step in range(1, 25)]
    (hit,) = [one.hits for one in met if len(one.hits.first)]
    assert hit.kind.tolist() == [Kind.WRECK]
    assert (hit.first.tolist(), hit.second.tolist()) == ([2], [0])
    assert [one.expired[:2].tolist() for one in met].index([True, True]) == 19  # step 20, 2 s after the crash
    encounters.forget(np.array([5, 2], np.int32))
    assert not encounters.update(30, crash).wrecked.any()


def test_a_slow_touch_stops_nobody():
    encounters = Encounters(RULES)
    met = encounters.update(0, people((0.0, 0.0, 0.0, 0.9), (3.9, 0.0, 0.0, 0.0), driven=[0]))
    assert met.hits.closing_mps == pytest.approx([0.9])
    assert not met.wrecked.any()


def test_critical_moments_are_counted_when_they_begin():
    """14 m/s onto a standing car: 1.5 s before contact at 21 m, and 14/(2·t) > 3.4 m/s² from t < 2.06 s on."""
    met = list(drive(25, 0, lambda s: people((14.0 * s, 0.0, 0.0, 14.0), (4.0 + 42.0, 0.0, 0.0, 0.0), driven=[0])))
    assert [step for step, one in met if one.critical_drac] == [10]
    assert [step for step, one in met if one.critical_ttc] == [16]


def test_a_driver_brakes_for_who_is_astray_after_the_reaction_time_and_stops_when_it_is_over():
    """Contact at 2 s is within the horizon at once; the threat ends at 1 s, and is forgotten a second later."""

    def scene(seconds):
        course = 180.0 if seconds < 0.999 else 90.0
        return people(
            (20.0 * seconds, 0.0, 0.0, 20.0), (84.0 - 20.0 * seconds, 0.5, course, 20.0), driven=[1], astray=[1]
        )

    met = list(drive(30, 3, scene))
    assert [step for step, one in met if one.braking[0]] == list(range(5, 20))
    assert not any(one.braking[1] for _, one in met)


def test_nobody_brakes_for_who_keeps_to_their_lane():
    met = list(drive(6, 0, lambda s: head_on(s, driven=[0, 1])))
    assert not any(one.braking.any() for _, one in met)
