from math import log, sqrt
from pathlib import Path

import pandas as pd
import pytest

from gpsec.paper import pool


def events(**columns):
    count = len(next(iter(columns.values())))
    table = {"run": ["r"] * count, "vehicle_id": [f"v{k}" for k in range(count)], "attack": ["a"] * count}
    return pd.DataFrame(table | columns)


SEEN = events(
    detector=["lstm_glr"] * 2,
    response=["ukf"] * 2,
    true_positives=[8, 0],
    false_positives=[2, 0],
    false_negatives=[2, 10],
    detection_delay_s=[0.4, None],
    detected=[True, False],
)


def test_detection_is_of_the_sums_over_all_events():
    found = pool.detection(SEEN)
    assert found["precision"].value == pytest.approx(0.8)
    assert found["recall"].value == pytest.approx(0.4)
    assert found["f1"].value == pytest.approx(16 / (16 + 2 + 12))
    assert found["delay_mean_s"].value == pytest.approx(0.4)  # of the detected
    assert found["detected_share"].value == 0.5
    assert {each.n for each in found.values()} == {2}
    # A resampled fleet is twice the one vehicle, twice the other, or both.
    assert (found["recall"].low, found["recall"].high) == (0.0, 0.8)


def test_no_event_has_no_figure():
    found = pool.detection(SEEN.iloc[:0])
    assert found["f1"] == pool.Estimate(None, None, None, 0)


def test_one_row_an_event_whichever_defences_listen():
    both = pd.concat([SEEN, SEEN.assign(response="dead_reckoning"), SEEN.assign(detector="cusum")])
    assert len(pool.of_detector(both, "lstm_glr", "a")) == 2
    assert len(pool.of_detector(both, "lstm_glr", "b")) == 0


def test_lead_over_the_best_of_others():
    worse = SEEN.assign(true_positives=[6, 0], false_negatives=[4, 10])
    other = SEEN.assign(true_positives=[4, 0], false_negatives=[6, 10])
    lead = pool.f1_lead(SEEN, [worse, other])
    assert lead.value == pytest.approx(16 / 30 - 12 / (12 + 2 + 14))
    assert lead.low is not None
    assert lead.low >= 0.0  # in pairs: no resampled fleet turns the order round
    assert pool.f1_lead(SEEN, [SEEN.iloc[::-1]]).value == 0.0
    with pytest.raises(ValueError, match="same events"):
        pool.f1_lead(SEEN, [SEEN.iloc[:1]])


def test_errors_are_pooled_over_time():
    zero = {name: [0.0, 0.0] for name in pool.ERRORS}
    largest = {name: [0.0, 0.0] for name in pool.LARGEST} | {"max_xy_m": [4.0, 1.0]}
    table = events(**(zero | largest | {"rmse_xy_m": [3.0, 1.0], "attack_seconds": [10.0, 30.0]}))
    found = pool.localization(table)
    assert found["rmse_xy_m"].value == pytest.approx(sqrt((9.0 * 10.0 + 1.0 * 30.0) / 40.0))
    assert found["rmse_x_m"].value == 0.0
    # An average maximum counts each event once.
    assert found["average_max_xy_m"].value == 2.5


def test_false_alarms_per_vehicle_hour():
    vehicles = pd.DataFrame(
        {
            "detector": ["lstm_glr", "lstm_glr", "lstm_glr", "lstm_glr"],
            "response": ["ukf", "ukf", "none", "ukf"],
            "attack": ["none", "none", "none", "a"],
            "false_alarms": [1, 2, 50, 70],
            "vehicle_seconds": [1800.0, 1800.0, 9.0, 9.0],
            "run": ["r"] * 4,
        }
    )
    assert pool.false_alarms(vehicles, "lstm_glr").value == pytest.approx(3.0)
    none = pool.false_alarms(vehicles.assign(false_alarms=0), "lstm_glr")
    assert (none.value, none.low) == (0.0, 0.0)
    assert none.high == pytest.approx(-log(0.025))  # of a Poisson count of 0 in one hour


def test_runs_are_told_apart(tmp_path: Path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "events.csv").write_text("scenario,vehicle_id,detected\ns,001,True\n")
    table = pool.read_runs([tmp_path / "one", tmp_path / "two"], "events")
    assert table["run"].tolist() == ["one", "two"]
    assert table["vehicle_id"].tolist() == ["001", "001"]


def test_runs_that_differ_widen_the_interval():
    # Two runs of 40 vehicles: one detector sees all of the one and none of the other.
    count = 80
    seen = events(
        detector=["lstm_glr"] * count,
        response=["ukf"] * count,
        true_positives=[10] * 40 + [0] * 40,
        false_positives=[0] * count,
        false_negatives=[0] * 40 + [10] * 40,
        detection_delay_s=[0.1] * count,
        detected=[True] * 40 + [False] * 40,
    )
    together = pool.detection(seen)["recall"]
    apart = pool.detection(seen.assign(run=["r"] * 40 + ["s"] * 40))["recall"]
    assert together.value == apart.value == 0.5
    assert (apart.low, apart.high) == (0.0, 1.0)
    assert together.high < 0.65
