"""`gpsec bench-detector`: the suite, what it refuses, and the table by hand."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.logs import Grid, ResidualLog
from gpsec.detection.plain import WindowDetector
from gpsec.detection.registry import DETECTORS
from gpsec.paper.leaderboard import (
    LEADERBOARD,
    LEADERBOARD_COLUMNS,
    enter,
    read_leaderboard,
    reference_leaderboard,
    suite_rows,
)
from gpsec.paper.suite import AS_KNOWN, QUICK, STANDARD, Candidate, suite_runs
from gpsec.paper.tryout import check_cost, look
from gpsec.scenario.networks import TRAINING_NETWORKS
from tests.outcomes.test_dictionary import documented
from tests.report.conftest import write_run

CUSUM = Candidate("cusum", (), None, "carla")


class Mean(WindowDetector):
    """Answers what it is told to answer."""

    name = "mean"
    samples = 3

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def score(self, windows: Any, profile: Any) -> Any:
        return self.answer(windows)


@pytest.fixture(scope="module")
def grid() -> Grid:
    vehicle, step = (part.ravel().astype(np.int32) for part in np.mgrid[:2, :30])
    size = len(vehicle)
    columns = dict.fromkeys(("speed_mps", "curvature_per_m", "camera_sigma_m"), np.full(size, 0.1))
    residual = np.random.default_rng(1).normal(0.0, 0.1, size)
    valid = np.ones(size, np.bool_)
    return Grid.of([ResidualLog("lane", "carla", "tracked", 0.1, 0.1, vehicle, step, residual, valid, **columns)])


def test_the_suite_is_run_on_networks_that_nobody_learns_on() -> None:
    assert not set(STANDARD.networks) & set(TRAINING_NETWORKS)
    runs = suite_runs(STANDARD, CUSUM)
    every = [one for members in runs.values() for one in members]
    assert len({one.name for one in every}) == len(every) == 3 * 3 + 3 * 3
    for one in runs["nothing"]:
        known = [plan.parameters.known() for plan in one.plans]
        targets = [target for each in known if each is not None for target in each.targets]
        assert targets == [
            "cusum",
            "cusum",
            "cusum@1/h",
            "cusum@1/h",
        ]
        assert one.defences[0].name == "never+none"
        assert one.fleet.profile == {"carla": 1.0}
    assert [plan.name for plan in runs["gnss_2"][0].plans] == ["stealth"]


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda windows: np.full(len(windows), np.nan), "detector 'mean': expected finite statistics.*found nan"),
        (lambda windows: np.full(len(windows), -1.0), "found -1.0 at 0.2 s"),
        (lambda windows: np.zeros(len(windows) + 1), r"detector 'mean': update: score must be \(0,\) of float64"),
        (lambda windows: windows[:, 7].mean(axis=1), r"detector 'mean': update: .*\(test_leaderboard.py:\d+\)"),
    ],
)
def test_answers_that_are_no_statistic_are_refused(grid: Grid, answer: Any, said: str) -> None:
    with pytest.raises(GpsecError, match=said):
        look(Mean(answer), grid)


def test_who_scores_nothing_or_takes_too_long_is_refused(grid: Grid) -> None:
    with pytest.raises(GpsecError, match="expected scores of 60 residuals, found none"):
        look(Mean(lambda windows: windows.mean(axis=1)), replace(grid, valid=np.zeros_like(grid.valid)))
    assert look(ChiSquare(), grid) == 0.0  # too short to be timed
    with pytest.raises(GpsecError, match=r"detector 'slow': expected at most 200 µs .* a track-step, found 300"):
        check_cost("slow", 300.0)


def test_rows_by_hand(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", log=False)
    for path in folder.glob("*.csv"):  # with the names of the suite
        text = path.read_text("utf-8").replace(",bias,", ",constant_bias,").replace("cusum+ukf", "cusum+ukf5_rollback")
        path.write_text(text, "utf-8")
    table = suite_rows(STANDARD, CUSUM, {"nothing": [folder]}, 1.5)
    assert tuple(table.columns) == LEADERBOARD_COLUMNS
    assert set(documented(LEADERBOARD)) == set(LEADERBOARD_COLUMNS)
    row = table[table["attack"] == "constant_bias"].iloc[0]
    assert (row["world"], row["rate"], row["n_vehicles"], row["detected_share"]) == ("nothing", "0.1/h", 2, 1.0)
    assert row["us_per_track_step"] == 1.5


def test_a_detector_takes_the_place_of_its_former_rows(tmp_path: Path) -> None:
    def rows(detector: str, unseen_m: float) -> pd.DataFrame:
        keys = {"suite": "quick", "detector": detector, "profile": "carla", "world": "nothing", "rate": "1/h"}
        row = keys | {"attack": "drift", "max_undetected_deviation_median_m": unseen_m}
        return pd.DataFrame([row], columns=list(LEADERBOARD_COLUMNS))

    enter(rows("first", 1.0), tmp_path)
    enter(rows("second", 2.0), tmp_path)
    table = enter(rows("first", 3.0), tmp_path)
    mine = table[table["suite"] == "quick"].set_index("detector")["max_undetected_deviation_median_m"]
    assert mine.to_dict() == {"second": 2.0, "first": 3.0}
    assert len(read_leaderboard(tmp_path / LEADERBOARD)) == len(table)
    (tmp_path / LEADERBOARD).write_text("a,b\n1,2\n")
    with pytest.raises(GpsecError, match="expected a leaderboard with the columns of this version"):
        read_leaderboard(tmp_path / LEADERBOARD)


def test_the_shipped_leaderboard_has_all_detectors_in_the_whole_suite() -> None:
    table = read_leaderboard(reference_leaderboard())
    assert set(table["suite"]) == {STANDARD.name}
    assert set(table["detector"]) == set(DETECTORS) - {"never", "told"}
    attackers = table[table["world"] == AS_KNOWN].groupby(["detector", "rate"])["attack"].agg(set)
    assert attackers.map(lambda found: found == set(STANDARD.attacks)).all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["cusun"], "no detector 'cusun': did you mean 'cusum'?"),
        (["told"], "no detector 'told'"),
        (["cusum", "--profile", "dsdd"], "--profile dsdd: expected one that gpsec has models of: did you mean 'dsd'?"),
        (["gpsec.attacks.drift:Drift"], "gpsec.attacks.drift:Drift: expected a detector, found another part, 'drift'"),
        (["nowhere.py:Mine"], "--part: part "),
    ],
)
def test_what_cannot_be_benchmarked_is_said(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["bench-detector", *arguments, "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_detector_of_gpsec_in_the_quick_suite(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench-detector", "chi_square", "--quick", "--out", str(tmp_path)]) == 0
    table = read_leaderboard(tmp_path / LEADERBOARD)
    assert table[table["suite"] == "quick"]["attack"].tolist() == list(QUICK.attacks)
    assert len(capsys.readouterr().out.splitlines()) <= 15
