"""Damaged archives of arrays give one kind of error, whatever is wrong with them."""

import zipfile
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpsec.core.npz import DamagedError, read_npz

ARRAYS = {"a": np.arange(12.0).reshape(3, 4), "b": np.array(["x", "long"]), "c": np.array(2), "d": np.zeros((0, 2))}


def packed(*, compressed: bool = True) -> bytes:
    stream = BytesIO()
    (np.savez_compressed if compressed else np.savez)(stream, **ARRAYS)
    return stream.getvalue()


def test_what_numpy_has_written_comes_back() -> None:
    found = read_npz(BytesIO(packed()))
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert found[name].dtype == array.dtype
        assert found[name].shape == array.shape
        assert (found[name] == array).all()


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 255), st.sampled_from(["set", "cut", "drop", "add"]), st.booleans())
def test_any_damage_is_one_kind_of_error(place: int, byte: int, how: str, compressed: bool) -> None:
    content = bytearray(packed(compressed=compressed))
    at = place % len(content)
    if how == "set":
        content[at] = byte
    elif how == "cut":
        del content[at:]
    elif how == "drop":
        del content[at]
    else:
        content.insert(at, byte)
    found, said = {}, ""
    try:
        found = read_npz(BytesIO(content))
    except DamagedError as error:
        said = str(error)
    assert bool(said) != bool(found)
    assert len(said) <= 100
    # The archive has a few bytes that nobody needs, and its checksums hold the rest.
    assert all((array == ARRAYS[name]).all() for name, array in found.items() if name in ARRAYS)


def member(content: bytes) -> bytes:
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("a.npy", content)
    return stream.getvalue()


def header(text: str) -> bytes:
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x93NUMPY\x09\x00",
        header("{'descr': '|O', 'fortran_order': False, 'shape': (1,)}\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000,)}\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': ('a',)}\n"),
        header("{'descr': 'nothing', 'fortran_order': False, 'shape': (1,)}\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (1,"),
        header("(" * 5000),
        header("__import__('os').abort()"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': ()}\n") + b"12345678and more",
    ],
)
def test_a_header_that_promises_what_is_not_there(content: bytes) -> None:
    with pytest.raises(DamagedError):
        read_npz(BytesIO(member(content)))
