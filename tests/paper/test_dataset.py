"""`gpsec dataset`: what it writes of a step, what the card says, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec import cli
from gpsec.paper.dataset import CARD, STATED, Export
from gpsec.paper.dataset_card import card, provenance_of
from gpsec.paper.dataset_log import MEASURED, DatasetLog
from gpsec.paper.suite import STANDARD
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.types.vehicles import Identity
from tests.outcomes.scene import Scene

FLEET = {row: Identity(f"car{row}", "car", 0, 0.0, f"car{row}") for row in range(3)}


@pytest.fixture
def steps(tmp_path: Path) -> Path:
    return write_steps(tmp_path / "test" / "lane-1.parquet")


def write_steps(path: Path) -> Path:
    """Write two steps of three vehicles; the last is attacked from the second step on, and has no fix in it."""
    scene = Scene(capacity=4)
    scene.vehicles.rear_m[:3, 0] = 5000.123456789
    scene.seen.lane_poly[:, 0] = -0.25
    scene.seen.camera_valid[0] = True
    scene.tracks.fix_valid[:] = scene.tracks.residual_valid[:] = True
    scene.tracks.residual_m[:] = 0.5
    with DatasetLog(path) as log:
        log.begin(scene.outcomes.study)
        log.see(scene.view(0, [0, 1, 2]), scene.outcomes.state, FLEET)
        scene.fork(2, 3, 1, 1)
        scene.tracks.fix_valid[3] = scene.tracks.residual_valid[3] = False
        log.see(scene.view(1, [0, 1, 2, 3]), scene.outcomes.state, FLEET)
    return path


def test_a_row_a_track_and_step(steps: Path) -> None:
    table = pd.read_parquet(steps)
    assert list(table.columns) == ["vehicle", "attack", *MEASURED]
    assert table["step"].tolist() == [0] * 3 + [1] * 4
    assert table["vehicle"].tolist() == ["car0", "car1", "car2", "car0", "car1", "car2", "car2"]
    assert table["attack"].tolist() == ["none"] * 6 + ["constant_bias"]
    assert table["attacked"].tolist() == [False] * 6 + [True]
    assert table["residual_m"].isna().tolist() == table["fix_east_m"].isna().tolist() == [False] * 6 + [True]
    assert table["camera_offset_m"].dropna().tolist() == [0.25, 0.25]
    assert table["true_east_m"].iloc[0] == 5000.123456789
    assert write_steps(steps.with_name("again.parquet")).read_bytes() == steps.read_bytes()


def test_splits_have_no_network_in_common() -> None:
    runs = Export("dsd").runs()
    assert [len(members) for members in runs.values()] == [3, 9, 9]
    seeds = {split: {one.seed for one in members} for split, members in runs.items()}
    assert not seeds["train"] & seeds["calibration"]
    assert not set(TRAINING_NETWORKS) & set(STANDARD.networks)
    names = [one.name for members in runs.values() for one in members]
    assert len(set(names)) == len(names)
    assert {plan.name for one in runs["test"] for plan in one.plans} == set(STANDARD.attacks[:-2])
    assert not any(one.plans for split in ("train", "calibration") for one in runs[split])
    assert {one.duration_s for members in Export("dsd", 30.0).runs().values() for one in members} == {30.0}


def test_the_card_says_every_column_and_attack(steps: Path) -> None:
    runs = {"test": Export("carla", 30.0, ("sharp_turns",)).runs()["test"][:1]}
    text = card("carla", runs, {"test": [steps]})
    assert all(f"| `{name}` |" in text for name in ("vehicle", "attack", *MEASURED, *STANDARD.attacks[:-2]))
    assert "| `test` | `lane-1` | 7 |" in text
    told = json.loads(provenance_of("carla", runs, {"test": [steps]}, steps.parents[1]))
    assert told["runs"]["test/lane-1.parquet"]["rows"] == 7
    assert len(told["runs"]["test/lane-1.parquet"]["sha256"]) == 64


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "expected an empty or new folder for a dataset, found one with files"),
        (["--networks", "town,surburb"], "--networks: no network 'surburb': did you mean 'suburb'?"),
        (["--profile", "dsdd"], "did you mean 'dsd'?"),
    ],
)
def test_what_cannot_be_exported_is_said(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert cli.main(["dataset", str(tmp_path), *arguments]) == 2
    assert said in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.slow
def test_the_same_bytes_twice_and_pyod_learns_from_them(tmp_path: Path) -> None:
    """PyOD's ECOD, on windows of ten residuals: trained on honest vehicles, it tells a bias from none."""
    from pyod.models.ecod import ECOD

    chosen = ["--networks", "suburb,sharp_turns", "--duration", "40"]
    for name in ("one", "two"):
        assert cli.main(["dataset", str(tmp_path / name), *chosen]) == 0
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*"))
    assert {Path(CARD), Path(STATED)} < set(files)
    for path in files:
        assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes()
    honest, _ = windows(sorted((tmp_path / "one" / "train").iterdir()))
    found, attacked = windows(sorted((tmp_path / "one" / "test").iterdir()))
    score = ECOD().fit(honest).decision_function(found)
    assert np.median(score[attacked]) > np.median(score[~attacked])


def windows(paths: list[Path]) -> tuple[np.ndarray, np.ndarray]:
    """Return the windows of ten residuals of each track, honest or under the constant bias, and their labels."""
    pieces, labels = [], []
    for path in paths:
        table = pd.read_parquet(path).dropna(subset=["residual_m"])
        table = table[table["attack"].isin(["none", "constant_bias"])]
        for _, track in table.groupby(["vehicle", "attack"], observed=True):
            if len(track) >= 10:
                pieces.append(np.lib.stride_tricks.sliding_window_view(track["residual_m"].to_numpy(), 10))
                labels.append(track["attacked"].to_numpy()[9:])
    return np.concatenate(pieces), np.concatenate(labels)
