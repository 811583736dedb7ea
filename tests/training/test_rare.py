"""`gpsec calibrate`: what is left to do, what is kept, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.detection.calibration import Calibrated
from gpsec.detection.models import ProfileModel, bundled, load_models, save, thresholds_for
from gpsec.detection.training import merged
from gpsec.training import calibrate, rare
from gpsec.training.rare import _done, with_rare

FOUND = {
    "cusum": {
        "0.1/h": Calibrated(9.0, 0.101, 0.08, 0.12),
        "0.01/h": Calibrated(12.0, 0.01, 0.007, 0.014, model=True),
        "1e-3/h": None,
    }
}


@pytest.fixture
def model() -> ProfileModel:
    learned = {"cusum": {name: np.float64(0.5) for name in ("white", "slow", "tau_s")}}
    rates = {
        "1/h": {"cusum": Calibrated(6.0, 1.0)},
        "0.1/h": {"cusum": Calibrated(8.0, 0.1)},
        "0.01/h": {"cusum": None},
    }
    return ProfileModel(learned, rates, {"detectors": {"cusum": {"slack": 0.75}}})


def test_thresholds_are_kept_with_what_they_were_made_of(model, tmp_path):
    save({("carla", "tracked"): with_rare(model, FOUND, 1000.0)}, tmp_path)
    models = load_models(tmp_path)
    loaded = models["carla", "tracked"]
    assert loaded.thresholds["0.1/h"] == {"cusum": FOUND["cusum"]["0.1/h"]}
    assert loaded.thresholds["0.01/h"] == {"cusum": FOUND["cusum"]["0.01/h"]}
    assert loaded.thresholds["1/h"] == model.thresholds["1/h"]
    points = [("cusum", "0.1/h"), ("cusum", "0.01/h")]
    assert thresholds_for(points, ["carla"], "tracked", models).tolist() == [[9.0, 12.0]]
    with pytest.raises(GpsecError, match=r"the nearest is '0.01/h'.*by the model of extreme values: 0.01/h"):
        thresholds_for([("cusum", "1e-3/h")], ["carla"], "tracked", models)


def test_a_rate_that_many_hours_do_not_tell_stays_as_fewer_told_it(model):
    untold = with_rare(model, {"cusum": {**FOUND["cusum"], "0.1/h": None}}, 1000.0)
    assert untold.thresholds["0.1/h"] == model.thresholds["0.1/h"]
    assert untold.thresholds["0.01/h"]["cusum"].model
    assert untold.thresholds["1e-3/h"] == {"cusum": None}


def test_what_is_done_is_not_done_again_until_something_else_was_learned(model):
    done = with_rare(model, FOUND, 1000.0)
    assert not _done(model, "cusum", 1000.0)
    assert _done(done, "cusum", 1000.0)
    assert not _done(done, "cusum", 2000.0)
    other = {"cusum": {**model.learned["cusum"], "white": np.float64(0.6)}}
    assert not _done(replace(done, learned=other), "cusum", 1000.0)


def test_what_is_behind_a_gate_is_done_anew_with_another_gate(model):
    rates = {
        rate: {**found, "joint": Calibrated(40.0, 0.1), "innovation": Calibrated(20.0, 0.1)}
        for rate, found in model.thresholds.items()
    }
    model = replace(model, thresholds=rates)
    moved = {"joint": {"0.1/h": Calibrated(45.0, 0.1)}, "innovation": {"0.1/h": Calibrated(21.0, 0.1)}}
    done = with_rare(model, {**FOUND, **{name: {**FOUND["cusum"], **one} for name, one in moved.items()}}, 1000.0)
    assert all(_done(done, name, 1000.0) for name in ("cusum", "joint", "innovation"))
    other = {**done.thresholds["0.1/h"], "joint": Calibrated(46.0, 0.1)}
    trained = replace(done, thresholds={**done.thresholds, "0.1/h": other})
    assert [_done(trained, name, 1000.0) for name in ("cusum", "joint", "innovation")] == [True, False, False]


def test_training_another_detector_keeps_them_and_the_same_one_does_not(model):
    done = with_rare(model, FOUND, 1000.0)
    latter = {"1/h": {"chi_square": Calibrated(3.0, 1.0)}, "0.01/h": {"chi_square": None}}
    both = merged(done, ProfileModel({}, latter, {"detectors": {"chi_square": {}}}))
    assert _done(both, "cusum", 1000.0)
    assert both.thresholds["0.01/h"] == {"cusum": FOUND["cusum"]["0.01/h"], "chi_square": None}
    again = merged(done, replace(model, provenance={"detectors": {"cusum": {"slack": 1.0}}}))
    assert not _done(again, "cusum", 1000.0)
    assert again.thresholds["0.01/h"] == {"cusum": None}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--profile", "dsdd"], "no model of profile 'dsdd': did you mean 'dsd'?"),
        (["--detector", "cusun"], "no model of detector 'cusun': did you mean 'cusum'?"),
    ],
)
def test_what_is_not_there_is_named(arguments, words, model, capsys, tmp_path):
    save({("dsd", "tracked"): model}, tmp_path)
    assert cli.main(["calibrate", *arguments, "--out", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err


def test_a_folder_without_models_is_named(capsys, tmp_path):
    assert cli.main(["calibrate", "--out", str(tmp_path)]) == 2
    assert "thresholds.json: no such file" in capsys.readouterr().err


@pytest.mark.slow
def test_a_model_is_calibrated_on_recorded_traffic_and_not_again(tmp_path, monkeypatch):
    monkeypatch.setattr(rare, "TRAINING_NETWORKS", ("mountain",))
    monkeypatch.setattr(rare, "CALIBRATION_RUNS", 1)
    trained = bundled()["carla", "tracked"]
    save({("carla", "tracked"): replace(trained, learned=dict(trained.learned))}, tmp_path / "models")
    wanted = {"hours": 100.0, "detectors": ["chi_square"], "jobs": 1}
    said = []
    assert calibrate(tmp_path / "models", **wanted, report=said.append) == ("carla/tracked",)
    assert any("of 100 vehicle-hours" in progress.stage for progress in said)
    rates = load_models(tmp_path / "models")["carla", "tracked"].thresholds
    counted, modelled = rates["0.1/h"]["chi_square"], rates["0.01/h"]["chi_square"]
    assert counted.lo < counted.achieved < counted.hi
    assert modelled.model
    assert modelled.threshold > counted.threshold
    assert rates["0.1/h"]["cusum"] == trained.thresholds["0.1/h"]["cusum"]
    assert calibrate(tmp_path / "models", **wanted) == ()
