"""Error tapes: what a sensor measured less what was true, sample by sample, as files (docs/tapes.md)."""

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats, Longs
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.npz import DamagedError, is_text, read_npz
from gpsec.core.system import in_a_sentence

TAPE_FORMAT = 1
TAPE_CHANNELS = {"camera": ("C0", "C1", "C2", "C3"), "gnss": ("east", "north")}
"""Kind of a tape -> what its columns are."""
_TYPES = {
    "format": "i8",
    "kind": "U",
    "rate_hz": "f8",
    "errors": "f8",
    "missing": "b1",
    "sigma_m": "f8",
    "piece": "i8",
    "median": "f8",
    "condition": "U",
    "provenance": "U",
    "digest": "U",
}
_SLOWEST_HZ, _FASTEST_HZ = 0.01, 1e4
_CONDITION = re.compile(r"[a-z0-9-]{1,40}")


@dataclass(frozen=True)
class Tape:
    """Recorded errors of one sensor; L samples in P pieces, K channels.

    Attributes:
        kind: of the sensor, a key of `TAPE_CHANNELS`.
        rate_hz: samples a second.
        errors: (L, K) measured less true, each piece less its median; 0 where missing.
        missing: (L,) the sensor gave nothing.
        sigma_m: (L,) standard deviation that the sensor stated for C0, or for one axis of a fix.
        piece: (P,) first sample of each piece; one sample follows another within a piece only.
        median: (P, K) what was taken out of each piece.
        condition: what the samples have in common.
        provenance: what made the tape, from what, with which settings; JSON.
    """

    kind: str
    rate_hz: float
    errors: Floats
    missing: Flags
    sigma_m: Floats
    piece: Longs
    median: Floats
    condition: str
    provenance: Mapping[str, Any]


def write_tape(tape: Tape, path: Path) -> str:
    """Write a tape and return its digest; a file that exists at `path` is whole or as before.

    Raises:
        GpsecError: the tape breaks a rule of the format, or the file cannot be written.
    """
    arrays: dict[str, NDArray[Any]] = {
        "format": np.array(TAPE_FORMAT, "<i8"),
        "kind": np.array(tape.kind),
        "rate_hz": np.array(tape.rate_hz, "<f8"),
        "errors": np.ascontiguousarray(tape.errors, "<f8"),
        "missing": np.ascontiguousarray(tape.missing, np.bool_),
        "sigma_m": np.ascontiguousarray(tape.sigma_m, "<f8"),
        "piece": np.ascontiguousarray(tape.piece, "<i8"),
        "median": np.ascontiguousarray(tape.median, "<f8"),
        "condition": np.array(tape.condition),
        "provenance": np.array(json.dumps(tape.provenance, sort_keys=True)),
    }
    digest = tape_digest(arrays)
    arrays["digest"] = np.array(digest)
    _checked(path, arrays)
    with in_a_sentence(f"{path}: no tape can be written there"):
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".tmp")
        try:
            with os.fdopen(handle, "wb") as stream:
                np.savez_compressed(stream, **dict(sorted(arrays.items())))  # type: ignore[arg-type]
            Path(name).chmod(0o644)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    return digest


def read_tape(path: Path) -> tuple[Tape, str]:
    """Return a tape with its digest.

    Raises:
        GpsecError: the file is missing or damaged, or breaks a rule of the format.
    """
    try:
        with path.open("rb") as stream:
            arrays = read_npz(stream)
    except FileNotFoundError:
        raise GpsecError(f"{path}: no such tape") from None
    except (OSError, DamagedError) as error:
        raise GpsecError(f"{path}: expected a tape (npz), found a broken file: {shown(error)}") from None
    return _checked(path, arrays), str(arrays["digest"])


def tape_digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return the SHA-256 of the arrays of a tape, `digest` left out, as docs/tapes.md defines it."""
    digest = hashlib.sha256()
    for name in sorted(set(arrays) - {"digest"}):
        array = arrays[name]
        for part in (name, array.dtype.str, ",".join(map(str, array.shape))):
            digest.update(part.encode() + b"\0")
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _checked(path: Path, arrays: Mapping[str, NDArray[Any]]) -> Tape:
    """Return the tape that the arrays are.

    Raises:
        GpsecError: they break a rule of the format.
    """
    if wrong := sorted(set(_TYPES) ^ set(arrays)):
        what = "found none" if wrong[0] in _TYPES else f"found one; {nearest(wrong[0], _TYPES)}"
        raise GpsecError(f"{path}: {shown(wrong[0])}: a tape has other arrays than expected, {what}")
    for name, expected in _TYPES.items():
        dtype = arrays[name].dtype
        if not dtype.isnative or (dtype.kind if expected == "U" else dtype.str[1:]) != expected:
            raise GpsecError(f"{path}: {name}: expected an array of type {expected}, found {shown(dtype)}")
        if dtype.kind == "f" and not np.isfinite(arrays[name]).all():
            raise GpsecError(f"{path}: {name}: expected finite numbers, found others")
        if not is_text(arrays[name]):
            raise GpsecError(f"{path}: {name}: expected a text, found letters that there are not")
    _check_sizes(path, arrays)
    _check_content(path, arrays)
    return Tape(
        str(arrays["kind"]),
        float(arrays["rate_hz"]),
        arrays["errors"],
        arrays["missing"],
        arrays["sigma_m"],
        arrays["piece"],
        arrays["median"],
        str(arrays["condition"]),
        _provenance(path, str(arrays["provenance"])),
    )


def _check_sizes(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    for name in ("format", "kind", "rate_hz", "condition", "provenance", "digest"):
        if arrays[name].shape != ():
            raise GpsecError(f"{path}: {name}: expected one value, found an array of shape {arrays[name].shape}")
    if (version := int(arrays["format"])) != TAPE_FORMAT:
        raise GpsecError(f"{path}: format: expected {TAPE_FORMAT}, found {version}")
    if (kind := str(arrays["kind"])) not in TAPE_CHANNELS:
        raise GpsecError(f"{path}: kind: unknown kind '{shown(kind)}'; {nearest(kind, TAPE_CHANNELS)}")
    samples, pieces, channels = len(np.atleast_1d(arrays["missing"])), arrays["piece"].size, len(TAPE_CHANNELS[kind])
    shapes = {
        "errors": (samples, channels),
        "missing": (samples,),
        "sigma_m": (samples,),
        "piece": (pieces,),
        "median": (pieces, channels),
    }
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise GpsecError(f"{path}: {name}: expected an array of shape {shape}, found {arrays[name].shape}")


def _check_content(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    rate_hz, missing, piece = float(arrays["rate_hz"]), arrays["missing"], arrays["piece"]
    if not _SLOWEST_HZ <= rate_hz <= _FASTEST_HZ:
        raise GpsecError(f"{path}: rate_hz: expected {_SLOWEST_HZ:g} to {_FASTEST_HZ:g}, found {rate_hz:g}")
    if missing.all():
        raise GpsecError(f"{path}: missing: expected a sample that is not missing, found none: the tape is empty")
    if not len(piece) or piece[0] != 0 or piece[-1] >= len(missing) or (np.diff(piece) <= 0).any():
        raise GpsecError(f"{path}: piece: expected ascending numbers of samples that begin with 0, found others")
    if (arrays["sigma_m"][~missing] <= 0.0).any():
        raise GpsecError(f"{path}: sigma_m: expected more than 0 where a sample is not missing, found less")
    if arrays["errors"][missing].any() or arrays["sigma_m"][missing].any():
        raise GpsecError(f"{path}: errors, sigma_m: expected 0 where a sample is missing, found others")
    if not _CONDITION.fullmatch(condition := str(arrays["condition"])):
        raise GpsecError(
            f"{path}: condition: expected up to 40 small letters, digits and '-', found '{shown(condition)}'"
        )
    if (found := str(arrays["digest"])) != (expected := tape_digest(arrays)):
        raise GpsecError(f"{path}: digest: expected {expected}, found {shown(found)}: the tape was changed")


def _provenance(path: Path, text: str) -> Mapping[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise GpsecError(f"{path}: provenance: expected a JSON object, found '{shown(text)}'")
    return found
