"""Calibration files: a camera as JSON."""

import json
from dataclasses import asdict, fields
from math import isfinite
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.system import in_a_sentence
from gpsec.imaging.pictures.camera import RoadCamera

_WHOLE = ("width", "height", "hood_row")
_BOUNDS = {
    "width": (16, 16384),
    "height": (16, 16384),
    "fx": (1.0, 1e6),
    "fy": (1.0, 1e6),
    "x_m": (-5.0, 30.0),
    "y_m": (-5.0, 5.0),
    "z_m": (0.2, 10.0),
    "roll_deg": (-45.0, 45.0),
    "pitch_deg": (-45.0, 45.0),
    "yaw_deg": (-45.0, 45.0),
}


def write_calibration(camera: RoadCamera, path: Path) -> None:
    """Write a calibration file.

    Raises:
        GpsecError: it cannot be written.
    """
    with in_a_sentence(f"{path}: no calibration can be written there"):
        part = path.with_name(f".{path.name}.part")
        part.write_text(json.dumps(asdict(camera), indent=2) + "\n", "utf-8")
        part.replace(path)


def read_calibration(path: Path) -> RoadCamera:
    """Return the camera that a calibration file describes.

    Raises:
        GpsecError: the file cannot be read, or a key is missing, unknown or out of bounds.
    """
    try:
        found = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        raise GpsecError(f"{path}: no such calibration file") from None
    except (OSError, ValueError, RecursionError) as error:
        raise GpsecError(f"{path}: expected a calibration (JSON), found: {shown(error)}") from None
    if not isinstance(found, dict):
        raise GpsecError(f"{path}: expected a JSON object, found {shown(found)}")
    keys = [field.name for field in fields(RoadCamera)]
    for key in found:
        if key not in keys:
            raise GpsecError(f"{path}: unknown key '{shown(key)}'; {nearest(key, keys)}")
    for key in keys:
        if key not in found:
            raise GpsecError(f"{path}: expected the key '{key}', found none")
    values = {key: _value(path, key, found[key]) for key in keys}
    if not 1 <= values["hood_row"] <= values["height"]:
        raise GpsecError(f"{path}: hood_row: expected 1 to {values['height']} (the height), found {values['hood_row']}")
    return RoadCamera(**values)


def _value(path: Path, key: str, value: Any) -> Any:
    if key == "distortion":
        if not isinstance(value, list) or len(value) != 5 or not all(_is_number(part) for part in value):
            raise GpsecError(f"{path}: distortion: expected five numbers (k1, k2, p1, p2, k3), found {shown(value)}")
        return tuple(float(part) for part in value)
    if not _is_number(value) or (key in _WHOLE and value != int(value)):
        what = "a whole number" if key in _WHOLE else "a number"
        raise GpsecError(f"{path}: {key}: expected {what}, found {shown(value)}")
    low, high = _BOUNDS.get(key, (-1e6, 1e6))
    if not low <= value <= high:
        raise GpsecError(f"{path}: {key}: expected {low:g} to {high:g}, found {shown(value)}")
    return int(value) if key in _WHOLE else float(value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
