import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpsec.core.errors import GpsecError
from gpsec.detection.models import build_detectors, load_models, save, thresholds_for
from gpsec.detection.registry import DETECTORS

NAMES = list(DETECTORS)


@pytest.fixture
def folder(model, tmp_path):
    save({("carla", "tracked"): model}, tmp_path)
    return tmp_path


def as_json(content):
    return json.loads(json.dumps(content))


def test_round_trip(model, folder):
    loaded = load_models(folder)["carla", "tracked"]
    assert loaded.thresholds == model.thresholds
    assert set(loaded.learned) == set(model.learned)
    for name, arrays in model.learned.items():
        for key, array in arrays.items():
            assert loaded.learned[name][key].tobytes() == np.asarray(array).tobytes()
            assert loaded.learned[name][key].dtype == np.asarray(array).dtype
    assert as_json(model.provenance) == loaded.provenance
    assert {"seed", "training", "calibration", "versions", "detectors"} <= set(loaded.provenance)


def test_same_models_give_same_bytes(model, folder, tmp_path):
    other = tmp_path / "again"
    save(load_models(folder), other)
    for path in other.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes()


def test_detectors_and_thresholds_come_by_name(folder):
    models = load_models(folder)
    detectors = build_detectors(NAMES, ["carla", "carla"], "tracked", models)
    assert [d.name for d in detectors] == NAMES
    table = thresholds_for([(name, "1e-3/sample") for name in NAMES], ["carla", "carla"], "tracked", models)
    assert table.shape == (2, len(NAMES))
    assert (table > 0.0).all()


@pytest.mark.parametrize(
    ("names", "profile", "matching", "rate", "message"),
    [
        (["lsmt"], "carla", "tracked", "1e-3/sample", "did you mean 'lstm'"),
        (["lstm_glr"], "carlo", "tracked", "1e-3/sample", "'carlo' with tracked .* 'gpsec train --profile carlo'"),
        (["lstm_glr"], "carla", "nearest", "1e-3/sample", "'carla' with nearest .* 'gpsec train --profile carla'"),
        (["lstm_glr"], "carla", "tracked", "1e-3/samples", "did you mean '1e-3/sample'"),
        (["lstm_glr"], "carla", "tracked", "0.1/h", "too little benign data"),
    ],
)
def test_unknown_choices_are_named(folder, names, profile, matching, rate, message):
    with pytest.raises(GpsecError, match=message):
        thresholds_for([(name, rate) for name in names], [profile], matching, load_models(folder))


@pytest.mark.parametrize("name", ["thresholds.json", "provenance.json", "carla-tracked.npz"])
@pytest.mark.parametrize("content", [None, b"", b"{", b"[" * 100_000, b"\xff", b'{"format": 0, "models": {}}'])
def test_missing_and_damaged_files_are_named(folder, name, content):
    if content is None:
        (folder / name).unlink()
    else:
        (folder / name).write_bytes(content)
    with pytest.raises(GpsecError, match=name):
        build_detectors(["lstm_glr"], ["carla"], "tracked", load_models(folder))


def test_truncated_arrays_are_named(folder):
    path = folder / "carla-tracked.npz"
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(GpsecError, match=r"carla-tracked\.npz"):
        build_detectors(["lstm_glr"], ["carla"], "tracked", load_models(folder))


def test_pickles_are_refused(folder):
    np.savez(folder / "carla-tracked.npz", **{"lstm_glr.weight": np.asarray([{"a": 1}], dtype=object)})
    with pytest.raises(GpsecError, match=r"carla-tracked\.npz"):
        build_detectors(["lstm_glr"], ["carla"], "tracked", load_models(folder))


def test_damaged_thresholds_are_named(folder):
    path = folder / "thresholds.json"
    document = json.loads(path.read_text())
    document["models"]["carla"]["tracked"]["1e-3/sample"]["lstm_glr"] = {"threshold": "high"}
    path.write_text(json.dumps(document))
    with pytest.raises(GpsecError, match=r"thresholds\.json"):
        load_models(folder)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("thresholds.json", "1e-3/sample", "1e-4/sample"),
        ("thresholds.json", '"threshold": ', '"threshold": 9'),
        ("thresholds.json", '"arrays"', '"array"'),
        ("thresholds.json", '"digest"', '"digests"'),
        ("provenance.json", '"seed": 3', '"seed": 4'),
        ("provenance.json", '"gpsec_version": "', '"gpsec_version": "9'),
    ],
)
def test_what_was_changed_by_hand_is_refused(folder, name, old, new):
    path = folder / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(GpsecError, match=f"{name}: damaged .it was changed"):
        load_models(folder)


def test_arrays_of_other_models_are_refused(model, folder, tmp_path):
    """They would run with thresholds that are not theirs."""
    other = tmp_path / "other"
    learned = {**model.learned, "cusum": {**model.learned["cusum"], "tau_s": np.asarray(7.0)}}
    save({("carla", "tracked"): replace(model, learned=learned)}, other)
    (other / "carla-tracked.npz").replace(folder / "carla-tracked.npz")
    with pytest.raises(GpsecError, match=r"carla-tracked.npz: damaged \(it is not the one that thresholds.json"):
        build_detectors(["cusum"], ["carla"], "tracked", load_models(folder))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(["thresholds.json", "provenance.json", "carla-tracked.npz"]),
    place=st.integers(0, 1 << 20),
    byte=st.integers(0, 255),
    cut=st.booleans(),
)
def test_models_are_what_they_were_or_refused(model, folder, name, place, byte, cut):
    path = folder / name
    before = path.read_bytes()
    content = bytearray(before)
    content[place % len(content)] = byte
    path.write_bytes(content[: place % len(content)] if cut else content)
    said = ""
    try:
        loaded = load_models(folder)["carla", "tracked"]
        build_detectors(NAMES, ["carla"], "tracked", load_models(folder))
    except GpsecError as error:
        said = str(error)
    finally:
        path.write_bytes(before)
    assert name in said or (loaded.thresholds == model.thresholds and loaded.provenance == as_json(model.provenance))
