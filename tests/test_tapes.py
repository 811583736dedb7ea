"""Tapes as files: what is written is read, and what is damaged is refused in a sentence."""

from dataclasses import replace

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.types.tapes import Tape, read_tape, tape_digest, write_tape


@pytest.fixture
def tape() -> Tape:
    missing = np.array([False, True, False, False, False])
    errors = np.arange(20.0).reshape(5, 4) * ~missing[:, None]
    sigma_m = np.where(missing, 0.0, 0.05)
    return Tape("camera", 20.0, errors, missing, sigma_m, np.array([0, 3]), np.ones((2, 4)), "rain", {"made_by": "me"})


@pytest.fixture
def arrays(tape, tmp_path):
    write_tape(tape, tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as stored:
        return dict(stored)


def test_what_is_written_is_read(tape, tmp_path):
    digest = write_tape(tape, tmp_path / "a.npz")
    found, stated = read_tape(tmp_path / "a.npz")
    assert stated == digest
    for name in ("errors", "missing", "sigma_m", "piece", "median"):
        np.testing.assert_array_equal(getattr(found, name), getattr(tape, name))
    assert (found.kind, found.rate_hz, found.condition, found.provenance) == ("camera", 20.0, "rain", {"made_by": "me"})


def test_the_same_tape_has_the_same_bytes(tape, tmp_path):
    for name in ("a.npz", "b.npz"):
        write_tape(tape, tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_digest_is_that_of_the_page(arrays):
    import hashlib

    own = hashlib.sha256()
    for name in sorted(set(arrays) - {"digest"}):
        shape = ",".join(str(size) for size in arrays[name].shape)
        own.update(f"{name}\0{arrays[name].dtype.str}\0{shape}\0".encode() + arrays[name].tobytes())
    assert str(arrays["digest"]) == own.hexdigest()


CHANGES = {
    "digest": ("errors", lambda a: a + (a > 0.0)),
    "format": ("format", lambda a: a + 1),
    "kind: unknown kind 'lidar'": ("kind", lambda a: np.array("lidar")),
    "kind: expected a text": ("kind", lambda a: np.array(["\ud800"]).reshape(())),
    "rate_hz": ("rate_hz", lambda a: a * 0.0),
    "errors: expected finite": ("errors", lambda a: a * np.nan),
    "errors: expected an array of shape": ("errors", lambda a: a[:, :2]),
    "errors: expected an array of type": ("errors", lambda a: a.astype(np.float32)),
    "tape is empty": ("missing", lambda a: a | True),
    "missing is missing|errors, sigma_m": ("missing", lambda a: a | (np.arange(5) == 4)),
    "piece": ("piece", lambda a: a[::-1].copy()),
    "sigma_m: expected more than 0": ("sigma_m", lambda a: a * 0.0),
    "condition": ("condition", lambda a: np.array("Rain at night!")),
    "provenance": ("provenance", lambda a: np.array("[1]")),
}


@pytest.mark.parametrize("said", CHANGES)
def test_a_tape_that_breaks_a_rule_is_refused(said, arrays, tmp_path):
    name, change = CHANGES[said]
    arrays[name] = change(arrays[name])
    if said != "digest":
        arrays["digest"] = np.array(tape_digest(arrays))
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(GpsecError, match=said):
        read_tape(tmp_path / "a.npz")


def test_an_array_too_few_and_a_file_that_is_none(arrays, tmp_path):
    del arrays["median"]
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(GpsecError, match="median: a tape has other arrays than expected, found none"):
        read_tape(tmp_path / "a.npz")
    (tmp_path / "b.npz").write_bytes(b"PK")
    with pytest.raises(GpsecError, match="expected a tape"):
        read_tape(tmp_path / "b.npz")
    with pytest.raises(GpsecError, match="no such tape"):
        read_tape(tmp_path / "c.npz")


def test_a_tape_that_breaks_a_rule_is_not_written(tape, tmp_path):
    with pytest.raises(GpsecError, match="condition"):
        write_tape(replace(tape, condition=""), tmp_path / "a.npz")
    assert list(tmp_path.iterdir()) == []
