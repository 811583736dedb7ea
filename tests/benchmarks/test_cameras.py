"""The table of cameras: which runs it takes, and how it is made of theirs."""

from pathlib import Path

import pandas as pd
import pytest

from benchmarks import cameras
from benchmarks.cameras import RETRAINED, SHIPPED, eyesights, goals, rows_of, scenario


def options(*arguments: str):
    return cameras._parser().parse_args(list(arguments))


def test_each_camera_is_a_scenario_of_its_own():
    seen = eyesights(["good", "rain"], 1.0, 0.1)
    assert [one.title for one in seen[:1] + seen[-2:]] == ["Gaussian", "pixels good", "pixels rain"]
    made = [scenario("highway", one, None, options(), 2) for one in seen]
    assert len({one.name for one in made}) == len(made)
    assert made[0].fleet.camera.tape is None
    assert made[1].fleet.camera.tape == "rendered-good"
    assert (made[-1].fleet.camera.image_weather, made[-1].fleet.camera.image_share) == ("rain", 1.0)
    assert {tuple(one.fleet.profile) for one in made} == {("dsd",)}
    assert [one.title for one in seen if one.held_out] == [
        "tape rendered-rain",
        "tape rendered-worn",
        "pixels good",
        "pixels rain",
    ]


def table(*rows: tuple[str, float, float, int, float]) -> pd.DataFrame:
    """Rows of detection.csv: attack, false-positive rate, hours, events, share detected."""
    names = ["attack", "false_positive_rate", "vehicle_hours", "n_events", "detected_share"]
    of = {"detector": "cusum@1e-3/sample", "rate": "1e-3/sample"}
    return pd.DataFrame([dict(zip(names, row, strict=True)) | of for row in rows])


def test_seeds_are_pooled_by_hours_and_by_events(monkeypatch: pytest.MonkeyPatch):
    tables = {
        "a": table(("none", 2e-3, 1.0, 0, float("nan")), ("stealth", 0.0, 1.0, 10, 0.5)),
        "b": table(("none", 6e-3, 3.0, 0, float("nan")), ("stealth", 0.0, 3.0, 30, 0.9)),
    }
    monkeypatch.setattr(cameras, "read_table", lambda folder, name: tables[folder.name])
    seen = eyesights([], 1.0, 0.1)[-1]
    (row,) = rows_of([Path("a"), Path("b")], seen, RETRAINED)
    assert row["detector"] == "cusum"
    assert row["false_alarms_per_1000_samples"] == pytest.approx((2.0 * 1.0 + 6.0 * 3.0) / 4.0)
    assert row["ratio_to_asked"] == pytest.approx(5.0)
    assert row["stealth_within_5_s"] == pytest.approx((0.5 * 10 + 0.9 * 30) / 40.0)


def test_who_keeps_the_false_alarms_asked_for_may_lead():
    rows = [
        {"camera": "pixels rain", "models": models, "detector": detector, "rate": "1e-3/sample", "held_out": True}
        | {"ratio_to_asked": ratio, "stealth_within_5_s": found}
        for models, detector, ratio, found in [
            (RETRAINED, "cusum", 1.4, 0.5),
            (RETRAINED, "lstm_glr", 1.6, 0.9),
            (RETRAINED, "chi_square", 0.7, 0.3),
            (SHIPPED, "joint", 1.0, 1.0),
        ]
    ]
    made = goals(pd.DataFrame(rows))
    cells = [next(iter(column.cells)) for column in made.columns]
    assert cells == ["pixels rain", "1e-3/sample", "cusum, chi_square", "lstm_glr (1.6)", "cusum (0.50)"]
