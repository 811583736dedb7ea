import json

import numpy as np
import pytest

from gpsec.detection.models import build_detectors, load, save, thresholds_for
from gpsec.detection.registry import DETECTORS
from gpsec.errors import GpsecError

NAMES = list(DETECTORS)


@pytest.fixture
def folder(model, tmp_path):
    save({("carla", "tracked"): model}, tmp_path)
    return tmp_path


def test_round_trip(model, folder):
    loaded = load(folder)["carla", "tracked"]
    assert loaded.thresholds == model.thresholds
    assert set(loaded.learned) == set(model.learned)
    for name, arrays in model.learned.items():
        for key, array in arrays.items():
            assert loaded.learned[name][key].tobytes() == np.asarray(array).tobytes()
            assert loaded.learned[name][key].dtype == np.asarray(array).dtype
    assert json.loads(json.dumps(model.provenance)) == loaded.provenance
    assert {"seed", "training", "calibration", "versions", "detectors"} <= set(loaded.provenance)


def test_same_models_give_same_bytes(model, folder, tmp_path):
    other = tmp_path / "again"
    save(load(folder), other)
    for path in other.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes()


def test_detectors_and_thresholds_come_by_name(folder):
    models = load(folder)
    detectors = build_detectors(NAMES, ["carla", "carla"], "tracked", models)
    assert [d.name for d in detectors] == NAMES
    table = thresholds_for(NAMES, ["carla", "carla"], "tracked", "1e-3/sample", models)
    assert table.shape == (2, len(NAMES))
    assert (table > 0.0).all()


@pytest.mark.parametrize(
    ("names", "profile", "matching", "rate", "message"),
    [
        (["lsmt"], "carla", "tracked", "1e-3/sample", "did you mean 'lstm'"),
        (["lstm"], "carlo", "tracked", "1e-3/sample", "did you mean 'carla/tracked'"),
        (["lstm"], "carla", "nearest", "1e-3/sample", "carla/nearest"),
        (["lstm"], "carla", "tracked", "1e-3/samples", "did you mean '1e-3/sample'"),
        (["lstm"], "carla", "tracked", "0.1/h", "too little benign data"),
    ],
)
def test_unknown_choices_are_named(folder, names, profile, matching, rate, message):
    with pytest.raises(GpsecError, match=message):
        thresholds_for(names, [profile], matching, rate, load(folder))


@pytest.mark.parametrize("name", ["thresholds.json", "provenance.json", "carla-tracked.npz"])
@pytest.mark.parametrize("content", [None, b"", b"{", b"not a model", b'{"format": 0, "models": {}}'])
def test_missing_and_damaged_files_are_named(folder, name, content):
    if content is None:
        (folder / name).unlink()
    else:
        (folder / name).write_bytes(content)
    with pytest.raises(GpsecError, match=name):
        build_detectors(["lstm"], ["carla"], "tracked", load(folder))


def test_truncated_arrays_are_named(folder):
    path = folder / "carla-tracked.npz"
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(GpsecError, match=r"carla-tracked\.npz"):
        build_detectors(["lstm"], ["carla"], "tracked", load(folder))


def test_pickles_are_refused(folder):
    np.savez(folder / "carla-tracked.npz", **{"lstm.weight": np.asarray([{"a": 1}], dtype=object)})
    with pytest.raises(GpsecError, match=r"carla-tracked\.npz"):
        build_detectors(["lstm"], ["carla"], "tracked", load(folder))


def test_damaged_thresholds_are_named(folder):
    path = folder / "thresholds.json"
    document = json.loads(path.read_text())
    document["models"]["carla"]["tracked"]["1e-3/sample"]["lstm"] = {"threshold": "high"}
    path.write_text(json.dumps(document))
    with pytest.raises(GpsecError, match=r"thresholds\.json"):
        load(folder)
