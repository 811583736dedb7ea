"""`gpsec judge`: a detector's own statistic, judged as a score, has the row that its run has."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec import cli
from gpsec.outcomes.aggregates import detection_table
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.tables import read_table
from gpsec.paper.dataset import STATED
from gpsec.paper.dataset_log import DatasetLog
from gpsec.paper.judging import JUDGED_TABLE, replay, study_of, thresholds_of
from gpsec.paper.scored import ScoredRun, read_scored
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

SETS = (
    "duration_s=45",
    "fleet.settle_s=5",
    "log_steps=true",
    'detection.detectors=["cusum"]',
    'detection.rates=["1e-3/sample"]',
    "defences=[]",
    'plans=[{attack="stealth",share=0.7,start_after_s=[0,15],duration_s=[5,10]},{attack="jamming",share=0.5}]',
    "outcomes.bootstrap=50",
)
# What depends on the score alone; thresholds are handed over, and the draws of a bootstrap are of another seed.
ALIKE = ("n_events", "precision", "recall", "f1", "delay_mean_s", "delay_median_s", "delay_p95_s", "detected_share")
ALIKE += ("false_positive_rate", "detected_not_twin_share", "alarm_ends_after_mean_s", "false_alarms_per_vehicle_hour")
ALIKE += ("vehicle_hours", "roc_auc", "pr_auc")


@pytest.fixture(scope="module")
def ran(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its dataset as both splits, and CUSUM's statistic as scores of them."""
    folder = tmp_path_factory.mktemp("ran")
    scenario = load_scenario(repository / "scenarios" / "sharp_turns", [parse_set(one) for one in SETS])
    file = folder / "data" / "test" / "sharp_turns-1.parquet"
    file.parent.mkdir(parents=True)
    with DatasetLog(file) as log:
        run_scenario(scenario, folder / "run", lambda _: None, onlooker=log)
    steps = pd.read_parquet(folder / "run" / "steps.parquet")
    rows = pd.read_parquet(file)
    steps = steps.assign(vehicle=steps["vehicle_id"], attack=steps["plan"], key=(steps["time_s"] * 10).round())
    rows = rows.astype({"vehicle": str, "attack": str}).assign(key=(rows["time_s"] * 10).round())
    score = next(name for name in steps if name.endswith("_statistic"))
    merged = rows.merge(steps[["vehicle", "attack", "key", score]], on=["vehicle", "attack", "key"], validate="1:1")
    for split in ("calibration", "test"):
        (folder / "scores" / split).mkdir(parents=True)
        (folder / "data" / split).mkdir(exist_ok=True)
        honest = split == "calibration"
        kept, made = (table[table["attack"] == "none"] if honest else table for table in (rows, merged))
        kept.drop(columns="key").to_parquet(folder / "data" / split / file.name)
        made = made.rename(columns={score: "score"})[["vehicle", "attack", "step", "score"]]
        made.sample(frac=1.0, random_state=1).to_parquet(folder / "scores" / split / file.name)  # in any order
    (folder / "data" / STATED).write_text(json.dumps({"profile": "carla"}))
    return folder


def scored(folder: Path, split: str = "test") -> ScoredRun:
    name = f"{split}/sharp_turns-1.parquet"
    return read_scored(folder / "data" / name, folder / "scores" / name)


def test_a_score_has_the_row_that_the_detector_has(ran: Path) -> None:
    own = read_table(ran / "run", "detection")
    own = own[(own["n_events"] > 0) & (own["rate"] == "1e-3/sample")].set_index("attack")
    run = scored(ran)
    threshold = float(own["threshold"].iloc[0])
    found = replay(run, np.array([threshold]))
    study = study_of(run, "cusum", "carla", {"1e-3/sample": threshold})
    judged = detection_table(study, found.tracks, found.counts, "sharp_turns", Bootstrap(1, 50)).set_index("attack")
    assert set(own.index) == {"stealth", "jamming"}
    assert own.loc["stealth", "detected_share"] > 0.5
    for attack in own.index:
        for column in ALIKE:
            mine, theirs = judged.loc[attack, column], own.loc[attack, column]
            assert mine == pytest.approx(theirs, rel=1e-8, nan_ok=True), (attack, column)


def test_thresholds_are_the_lowest_that_calibration_allows(ran: Path) -> None:
    run = scored(ran, "calibration")
    told = thresholds_of([(replay(run, np.full(1, np.inf)), run.step_s)])
    assert list(told) == ["1e-3/sample"]  # a minute of traffic tells no rarer one
    score = run.score[run.settled & ~np.isnan(run.score)]
    assert (score > told["1e-3/sample"]).mean() <= 1e-3 < (score > 0.99 * told["1e-3/sample"]).mean()


def test_the_command_writes_a_table_with_each_file_attack_and_rate(
    ran: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["judge", str(ran / "data"), str(ran / "scores"), "--name", "mine"]) == 0
    table = read_table(ran / "scores", JUDGED_TABLE.removesuffix(".csv"))
    assert table[["scenario", "attack"]].to_numpy().tolist() == [
        ["sharp_turns-1", attack] for attack in ("none", "jamming", "stealth")
    ]
    assert set(table["detector"]) == {"mine@1e-3/sample"}
    assert table.set_index("attack").loc["stealth", "f1"] > 0.2
    said = capsys.readouterr().out
    assert "stealth" in said
    assert "3 rows" in said


def _without(name: str):
    return lambda table: table.drop(columns=name)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (_without("score"), "found no 'score'"),
        (lambda table: table.assign(score=-1.0), "column 'score': expected finite numbers of at least 0"),
        (lambda table: table.assign(score=np.inf), "found inf; any rising function of a score will do"),
        (lambda table: table.assign(score="high"), "column 'score': expected numbers"),
        (lambda table: pd.concat([table, table.tail(1)]), "two scores of vehicle"),
        (
            lambda table: table.assign(vehicle="nobody", step=range(len(table))),
            "rows are of no vehicle, attack and step of",
        ),
        (lambda table: table.head(3), "too few scores for a threshold"),
        (None, "expected scores, found no file"),
    ],
)
def test_what_cannot_be_judged_is_said(
    damage, said: str, ran: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "calibration").mkdir()
    if damage is not None:
        table = pd.read_parquet(ran / "scores" / "calibration" / "sharp_turns-1.parquet")
        damage(table).to_parquet(tmp_path / "calibration" / "sharp_turns-1.parquet")
    assert cli.main(["judge", str(ran / "data"), str(tmp_path)]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / JUDGED_TABLE).exists()


def test_a_folder_that_is_no_dataset_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["judge", str(tmp_path), str(tmp_path)]) == 2
    assert "expected what gpsec dataset has written" in capsys.readouterr().err
