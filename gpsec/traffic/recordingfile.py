"""Recordings as files: .npz without pickle, made on one net and refused on any other."""

import hashlib
import os
import tempfile
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.core.errors import GpsecError, shown
from gpsec.core.npz import DamagedError, is_text, read_npz
from gpsec.core.version import __version__
from gpsec.traffic.inputs import UNREADABLE, open_input
from gpsec.traffic.recording import NameColumn, Recording

RECORDING_FORMAT = 4
_KINDS = {Floats: "f8", Ints: "i4", Longs: "i8", Flags: "?", NameColumn: "U"}
# No net and no vehicle is larger or faster; what is beyond would leave the grid of the map.
_FARTHEST_M, _LONGEST_M, _FASTEST_MPS, _LONGEST_STEP_S = 1e7, 1e3, 1e3, 1.0


class OnNet(NamedTuple):
    """The net that a recording is of.

    Attributes:
        digest: SHA-256 of the net, unpacked.
        lanes: in its map.
    """

    digest: str
    lanes: int


def on_net(net_file: Path, lanes: int) -> OnNet:
    """Return the identity of a net, of which the map has `lanes` lanes.

    Raises:
        GpsecError: it cannot be read.
    """
    digest = hashlib.sha256()
    try:
        with open_input(net_file) as stream:
            while part := stream.read(1 << 20):
                digest.update(part)
    except UNREADABLE as error:
        raise GpsecError(f"{net_file}: expected a net, found a file that cannot be read: {shown(error)}") from None
    return OnNet(digest.hexdigest(), lanes)


def save_recording(recording: Recording, path: Path, net: OnNet) -> None:
    """Write a recording that was made on `net`; a file that exists at `path` is whole or as before."""
    arrays: dict[str, Any] = {field.name: getattr(recording, field.name) for field in fields(recording)}
    arrays |= {
        "format": np.array([RECORDING_FORMAT]),
        "net": np.array([net.digest]),
        "gpsec_version": np.array([__version__]),
    }
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as stream:
            np.savez_compressed(stream, **arrays)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def load_recording(path: Path, net: OnNet) -> Recording:
    """Read what `save_recording` wrote, and check that a run on `net` can take it.

    Raises:
        GpsecError: the file is missing, broken, of another format or another net, or does not fit together.
    """
    try:
        with path.open("rb") as stream:
            stored = read_npz(stream)
    except FileNotFoundError:
        raise GpsecError(f"{path}: recording not found") from None
    except (OSError, DamagedError) as error:
        raise GpsecError(f"{path}: expected a recording (npz), found a broken file: {shown(error)}") from None
    stated = {name: _stated(stored.pop(name, None)) for name in ("format", "net", "gpsec_version")}
    if stated["format"] != str(RECORDING_FORMAT):
        raise GpsecError(
            f"{path}: expected a recording of format {RECORDING_FORMAT}, found {shown(stated['format'] or 'none')}"
        )
    if stated["net"] != net.digest:
        made = shown(stated["gpsec_version"] or "?")
        raise GpsecError(f"{path}: expected a recording of this net, found one of another net (made by gpsec {made})")
    names = {field.name for field in fields(Recording)}
    if names != set(stored):
        wrong = ", ".join(map(shown, sorted(names ^ set(stored))))
        raise GpsecError(f"{path}: a recording has other arrays than expected: {wrong}")
    _check_arrays(path, stored)
    recording = Recording(**stored)
    _check_shapes(path, recording)
    _check_values(path, recording, net.lanes)
    _check_rows(path, recording)
    return recording


def _stated(array: NDArray[Any] | None) -> str:
    """Return the one value of an array as text, empty where it is no such array."""
    if array is None or array.shape != (1,) or array.dtype.kind not in "iU" or not is_text(array):
        return ""
    return str(array[0])


def _check_arrays(path: Path, stored: dict[str, NDArray[Any]]) -> None:
    """Refuse arrays of another type, and numbers and letters that are none."""
    for name, kind in get_type_hints(Recording).items():
        array, expected = stored[name], _KINDS[kind]
        dtype = array.dtype
        if not dtype.isnative or (dtype.kind if expected == "U" else dtype.str[1:]) != expected.replace("?", "b1"):
            raise GpsecError(f"{path}: {name}: expected an array of type {expected}, found {shown(dtype)}")
        if dtype.kind == "f" and not np.isfinite(array).all():
            raise GpsecError(f"{path}: {name}: expected finite numbers, found others")
        if not is_text(array):
            raise GpsecError(f"{path}: {name}: expected texts, found letters that there are not")


def _check_shapes(path: Path, recording: Recording) -> None:
    """Refuse arrays that do not fit together."""
    r = recording
    parts: tuple[tuple[NDArray[Any], tuple[NDArray[Any], ...]], ...] = (
        (r.start, (r.rows, r.front_m, r.lane)),
        (r.left_start, (r.left,)),
        (r.departure_start, tuple(getattr(r, field.name) for field in fields(r)[11:-3])),
        (r.spoofer_start, (r.spoofer_plan, r.spoofer_m)),
    )
    pairs = ("front_m", "spoofer_m")
    whole = r.step_s.shape == (1,) and all(
        getattr(r, field.name).shape[1:] == ((2,) if field.name in pairs else ()) and getattr(r, field.name).ndim > 0
        for field in fields(r)
    )
    whole = whole and len(r.step) == len(r.time_s) == len(r.on_road)
    for start, arrays in parts:
        whole = whole and len(start) == len(r.step) + 1 and start[0] == 0 and bool((start[1:] >= start[:-1]).all())
        whole = whole and all(len(array) == start[-1] for array in arrays)
    if not whole:
        raise GpsecError(f"{path}: the arrays of the recording do not fit together: record it again")


def _check_values(path: Path, recording: Recording, lanes: int) -> None:
    """Refuse values that no traffic has, such as a lane that the map has not."""
    r = recording
    bounds: dict[str, tuple[float, float]] = {
        "lane": (0, lanes - 1),
        "rows": (0, len(r.departure_row) - 1),
        "left": (0, len(r.departure_row) - 1),
        "departure_row": (0, len(r.departure_row) - 1),
        "on_road": (0, np.inf),
        "step_s": (1e-3, _LONGEST_STEP_S),
        "front_m": (-_FARTHEST_M, _FARTHEST_M),
        "spoofer_m": (-_FARTHEST_M, _FARTHEST_M),
        "length_m": (1e-3, _LONGEST_M),
        "width_m": (1e-3, _LONGEST_M),
        "yaw_rad": (-100.0, 100.0),
        "speed_mps": (0.0, _FASTEST_MPS),
        "equipped_share": (0.0, 1.0),
    }
    for name, (low, high) in bounds.items():
        array = getattr(r, name)
        outside = array[(array < low) | (array > high)]
        if len(outside):
            raise GpsecError(f"{path}: {name}: expected {low:g} to {high:g}, found {outside[0]:g}")
    if len(r.step) and (r.step[0] < 0 or (np.diff(r.step.astype(np.int64)) != 1).any()):
        raise GpsecError(f"{path}: step: expected one number after the other, found others")
    if (np.diff(r.time_s) <= 0.0).any():
        raise GpsecError(f"{path}: time_s: expected times that grow, found others")


def _check_rows(path: Path, recording: Recording) -> None:
    """Refuse vehicles that drive or leave without having departed, and two in one row."""
    r = recording
    there = np.zeros(len(r.departure_row), np.bool_)
    for frame in range(len(r)):
        rows, left, entered = (
            array[start[frame] : start[frame + 1]]
            for array, start in (
                (r.rows, r.start),
                (r.left, r.left_start),
                (r.departure_row, r.departure_start),
            )
        )
        fits = there[left].all() and len(np.unique(left)) == len(left)
        there[left] = False
        fits = fits and not there[entered].any() and len(np.unique(entered)) == len(entered)
        there[entered] = True
        if not (fits and there[rows].all() and (rows[1:] > rows[:-1]).all()):
            expected = f"rows of frame {frame}: expected vehicles that have departed, each once"
            raise GpsecError(f"{path}: {expected}, found others")
