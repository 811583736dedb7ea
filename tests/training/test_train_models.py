import time

import numpy as np
import pytest
from rich.console import Console

from gpsec import cli
from gpsec.console.train import display_training
from gpsec.core import shipped
from gpsec.detection.calibration import Calibrated
from gpsec.detection.models import ProfileModel, load_models
from gpsec.detection.training import merged, related
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.training.pool import Pool


def test_networks_that_there_are_not_are_named(capsys, tmp_path):
    assert cli.main(["train", "--networks", "mountain,suburbs", "--out", str(tmp_path)]) == 2
    assert "no training network 'suburbs': did you mean 'suburb'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--detector", "cusun"], "unknown detector 'cusun': did you mean 'cusum'?"),
        (["--profile", "dsdd"], "unknown sensor profile 'dsdd': did you mean 'dsd'?"),
        (["--part", "nowhere.py:X"], "--part: part "),
    ],
)
def test_what_is_not_there_is_named_before_anything_is_simulated(arguments, words, capsys, tmp_path):
    assert cli.main(["train", *arguments, "--out", str(tmp_path / "made")]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


def test_a_folder_of_something_else_is_not_written_to(capsys, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert cli.main(["train", "--out", str(tmp_path)]) == 2
    assert "thresholds.json" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_detectors_that_share_arrays_are_trained_together():
    assert related(["cusum"]) == ("cusum",)
    assert related(["lstm"]) == ("lstm",)
    assert related(["lstm_cusum"]) == related(["lstm_glr"]) == ("lstm_glr", "lstm_cusum")
    # They share the monitor's gate, which is the threshold of one of them.
    assert related(["innovation"]) == related(["joint"]) == ("innovation", "joint", "separation")
    assert related(["lstm_glr", "chi_square"]) == ("chi_square", "lstm_glr", "lstm_cusum")


def test_what_is_not_trained_stays_and_is_said_to():
    former = ProfileModel(
        {"cusum": {"white": np.zeros(1)}, "lstm_glr": {"weight": np.zeros(2)}},
        {"1/h": {"cusum": Calibrated(1.0, 0.1), "lstm_glr": Calibrated(2.0, 0.1)}},
        {"seed": 1, "detectors": {"cusum": {"slack": 1.0}, "lstm_glr": {}}},
    )
    latter = ProfileModel(
        {"cusum": {"white": np.ones(1)}},
        {"1/h": {"cusum": Calibrated(3.0, 0.2)}},
        {"seed": 2, "detectors": {"cusum": {"slack": 2.0}}},
    )
    both = merged(former, latter)
    assert both.learned["cusum"]["white"] == 1.0
    assert both.learned["lstm_glr"] is former.learned["lstm_glr"]
    assert both.thresholds["1/h"] == {"cusum": Calibrated(3.0, 0.2), "lstm_glr": Calibrated(2.0, 0.1)}
    assert both.provenance["detectors"] == {"cusum": {"slack": 2.0}, "lstm_glr": {}}
    assert both.provenance["kept"] == {"detectors": ["lstm_glr"], "from": {"seed": 1}}
    assert merged(None, latter) is latter


def test_each_result_is_kept_as_soon_as_it_is_there(tmp_path):
    kept = []
    told = []
    pool = Pool(1, tmp_path, told.append)
    assert pool.run("sums", [("three", sum, ((1, 2),)), ("seven", sum, ((3, 4),))], lambda *one: kept.append(one)) == [
        *(3, 7)
    ]
    assert kept == [(0, 3), (1, 7)]
    assert told[-1] == ("sums", "2 of 2 done", 2, 2)


@pytest.mark.slow
def test_a_call_that_fails_ends_those_that_are_left_and_nothing_else_is_said(tmp_path, capfd):
    pool = Pool(2, tmp_path, lambda progress: None)
    with pytest.raises(ValueError, match="invalid literal"):
        pool.run("calls", [("bad", int, ("x",)), *(("long", time.sleep, (600.0,)) for _ in range(4))])
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_one_detector_and_one_profile_are_trained_by_themselves(tmp_path, capsys):
    chosen = ["--networks", "mountain", "--detector", "cusum", "--profile", "dsd"]
    assert cli.main(["train", *chosen, "--out", str(tmp_path / "made")]) == 0
    assert "2 models in" in capsys.readouterr().out
    made = load_models(tmp_path / "made")
    assert set(made) == {("dsd", "tracked"), ("dsd", "nearest")}
    assert list(made["dsd", "tracked"].learned) == ["cusum"]
    run = ["run", "slow_curve", "--duration", "20", "--profile", "dsd", "--no-report", "--out", str(tmp_path / "run")]
    chosen = ["--set", f"detection.models={tmp_path / 'made'}", "--set", 'detection.detectors=["cusum"]']
    assert cli.main([*run, *chosen, "--set", 'defences=[{detector="cusum", response="ukf"}]']) == 0


def test_elsewhere_than_on_a_terminal_progress_is_plain_lines(capsys, tmp_path):
    with display_training(Console(force_terminal=False)) as report:
        Pool(1, tmp_path, report).run("sums", [("three", sum, ((1, 2),)), ("seven", sum, ((3, 4),))])
    assert capsys.readouterr().out.splitlines()[-1] == "sums: 2 of 2 done"


@pytest.mark.parametrize("network", TRAINING_NETWORKS)
def test_every_training_network_has_a_scenario(network):
    assert (shipped.scenarios() / network / f"{network}.sumocfg").is_file()
