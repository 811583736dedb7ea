"""The table of step lengths: what it reads is what its runs score, and which intervals it takes to be apart."""

import pandas as pd

from benchmarks.steps import DETECTORS, STEPS_S, apart, scenario
from gpsec.types.points import PER_SAMPLE, point_name


def test_alarms_and_defences_of_the_table_are_those_of_its_runs():
    made = scenario(0.05, 2, 30.0)
    points = [point_name(name, PER_SAMPLE) for name in DETECTORS]
    assert made.detection.rates == (PER_SAMPLE,)
    assert [one.name for one in made.defences] == ["never+none", *(f"{point}+ukf" for point in points)]
    assert (made.traffic.step_s, made.seed) == (0.05, 2)


def test_intervals_that_do_not_meet_that_of_the_longest_step_are_apart():
    rows = [(STEPS_S[0], 1.0, 2.0), (STEPS_S[1], 1.9, 3.0), (STEPS_S[2], 2.1, 3.0), (STEPS_S[3], 0.0, 0.9)]
    measured = pd.DataFrame(rows, columns=["step_s", "low", "high"])
    measured[["profile", "detector", "attack", "quantity"]] = "dsd", "cusum", "none", "false_alarms_per_h"
    assert list(apart(measured[1:], measured)["step_s"]) == [STEPS_S[2], STEPS_S[3]]
