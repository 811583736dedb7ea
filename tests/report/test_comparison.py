import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.report.comparison import FALSE_ALARMS, FIGURES, comparison, pairs
from gpsec.report.comparison_page import write_comparison
from gpsec.report.formatting import figure
from gpsec.running.results import load

from .conftest import write_run


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The same vehicles, off by 2 m and by 1 m: out of the lane (beyond 1.75 m), and still in it."""
    folder = tmp_path_factory.mktemp("pairs")
    far, near = (write_run(folder / name, error_m=error, log=False) for name, error in (("far", 2.0), ("near", 1.0)))
    return load(far), load(near)


def row(table, **choice):
    for column, value in choice.items():
        table = table[table[column] == value]
    assert len(table) == 1
    return table.iloc[0]


def test_differences_by_hand(runs):
    table = comparison(*runs)
    mine = {"attack": "bias", "defence": "never+none"}
    largest = row(table, figure=FIGURES["max_cross_track_m"], **mine)
    assert (largest["first"], largest["second"], largest["difference"]) == (2.0, 1.0, -1.0)
    # Every pair has the same difference, and so has every fleet that is drawn from them.
    assert (largest["difference_lo"], largest["difference_hi"]) == (-1.0, -1.0)
    left = row(table, figure=FIGURES["left_lane"], **mine)
    assert (left["first"], left["second"], left["n_vehicles"]) == (1.0, 0.0, 2)
    assert FIGURES["detection_delay_s"] not in set(table.loc[table["defence"] == "never+none", "figure"])


def test_intervals_are_those_of_a_bootstrap_over_pairs(runs, tmp_path):
    first, second = runs
    folder = shutil.copytree(second.folder, tmp_path / "mixed")
    events = pd.read_csv(folder / "events.csv", keep_default_na=False, dtype=str)
    values = np.array([0.0, 3.0])
    mine = (events["attack"] == "bias") & (events["defence"] == "never+none")
    events.loc[mine, "rmse_xy_m"] = values.astype(str)
    events.to_csv(folder / "events.csv", index=False)
    found = row(comparison(first, load(folder)), attack="bias", defence="never+none", figure=FIGURES["rmse_xy_m"])
    before = first.events.loc[
        (first.events["attack"] == "bias") & (first.events["defence"] == "never+none"), "rmse_xy_m"
    ].to_numpy()
    differences = values - before
    assert found["difference"] == pytest.approx(differences.mean())
    # Of two pairs, a fleet has twice the one, twice the other, or both.
    assert found["difference_lo"] == pytest.approx(differences.min())
    assert found["difference_hi"] == pytest.approx(differences.max())


def test_false_alarms_are_compared_without_an_attack(runs):
    found = row(comparison(*runs), attack="none", defence="cusum+ukf")
    assert found["figure"] == FALSE_ALARMS
    assert (found["n_vehicles"], found["first"], found["difference"]) == (6, 0.0, 0.0)


def test_attacks_at_other_times_are_no_pairs(runs, tmp_path):
    first, second = runs
    folder = shutil.copytree(second.folder, tmp_path / "later")
    events = pd.read_csv(folder / "events.csv", keep_default_na=False, dtype=str)
    events.loc[events["vehicle_id"] == "b", "start_s"] = "9.9"
    events.to_csv(folder / "events.csv", index=False)
    shared, alone = pairs(first, load(folder))
    assert "b" not in set(shared["vehicle_id"])
    assert (len(shared), alone) == (10, 4)
    events["start_s"] = "9.9"
    events.to_csv(folder / "events.csv", index=False)
    with pytest.raises(GpsecError, match=r"later: expected a run with attacked vehicles and defences of .*far"):
        pairs(first, load(folder))


def test_the_page_says_what_differs(runs, tmp_path):
    first, second = runs
    folder = shutil.copytree(second.folder, tmp_path / "other")
    stated = json.loads((folder / "manifest.json").read_text())
    stated["scenarios"][0]["configuration"]["detection"]["rates"] = ["1e-4/sample"]
    (folder / "manifest.json").write_text(json.dumps(stated))
    text = write_comparison(first, load(folder)).read_text("utf-8")
    assert "lane: detection.rates.0 is 1e-3/sample, then 1e-4/sample" in text
    assert "12 pairs" in text
    assert "<img" not in text


@pytest.mark.parametrize(
    ("value", "percent", "text"),
    [(-0.004, False, "0.00"), (-0.006, False, "-0.01"), (0.0, False, "0.00"), (-0.0004, True, "0.0 %")],
)
def test_what_rounds_to_zero_has_no_sign(value, percent, text):
    assert figure(value, percent=percent) == text


def test_a_difference_that_rounds_to_zero_has_no_sign(runs, tmp_path):
    first = runs[0]
    folder = shutil.copytree(first.folder, tmp_path / "near")
    events = pd.read_csv(folder / "events.csv", keep_default_na=False)
    events["rmse_xy_m"] += np.where(events["attack"] == "bias", 0.001, -0.001)
    events.to_csv(folder / "events.csv", index=False)
    text = write_comparison(first, load(folder), tmp_path / "page.html").read_text("utf-8")
    assert not re.search(r">[+-]0\.00\s*<", text)
