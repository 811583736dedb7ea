"""Reads a log as CSV: a row for each time, a cell left empty where a sensor gave nothing then (docs/replay.md)."""

from math import pi
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.geo import Projector
from gpsec.replay.log import NO_PROJECTION, DriveLog, Fixes, Samples, projection_at

TIME = "t_s"
# Ways to say the same; each is columns, and what makes SI units and our directions of their values.
_LON_LAT = ("lon_deg", "lat_deg")
_POSITION = (("x_m", "y_m"), _LON_LAT)
_LANE = ("c0_m", "c1", "c2_per_m", "c3_per_m2", "camera_sigma_m")
_PLAIN, _DEGREES, _COMPASS = (1.0, 0.0), (pi / 180.0, 0.0), (-pi / 180.0, pi / 2.0)
_YAW = {"yaw_rad": _PLAIN, "yaw_deg": _DEGREES, "yaw_compass_deg": _COMPASS}
_HEADING = {"heading_rad": _PLAIN, "heading_deg": _DEGREES, "heading_compass_deg": _COMPASS}
_YAW_RATE = {"yaw_rate_rps": _PLAIN, "yaw_rate_dps": _DEGREES}
_SPEED = {"speed_mps": _PLAIN}
LOG_COLUMNS = (
    TIME,
    *(name for names in _POSITION for name in names),
    *(f"fix_{name}" for names in _POSITION for name in names),
    "fix_age_s",
    *_YAW,
    *_HEADING,
    *_YAW_RATE,
    *_SPEED,
    *_LANE,
)
_LARGEST = {"yaw_rad": 2.0 * pi, "heading_rad": 2.0 * pi, "lon_deg": 180.0, "lat_deg": 90.0}
_LARGEST |= {f"fix_{name}": _LARGEST[name] for name in _LON_LAT}


def read_csv_log(file: Path) -> DriveLog:
    """Read a log.

    Raises:
        GpsecError: the file is missing, a column is not known or missing, or a cell holds no number.
    """
    table = _read(file)
    names = {str(name) for name in table.columns}
    on_earth = set(_LON_LAT) <= names
    _check_columns(file, names)
    position = _LON_LAT if on_earth else _POSITION[0]
    first = table[list(position)].dropna().head(1).to_numpy()
    if not len(first):
        raise GpsecError(f"{file}: {position[0]}, {position[1]}: expected positions, found empty cells only")
    projection = projection_at(*first[0]) if on_earth else NO_PROJECTION
    projector = Projector(projection, source=str(file))
    yaw = _one_of(table, _YAW)
    if yaw is None:
        raise GpsecError(f"{file}: expected one of the columns {', '.join(_YAW)}, found none")
    there = table[list(position)].notna().all(axis=1).to_numpy() & ~np.isnan(yaw)
    pose = np.column_stack([_metres(table, position, projector)[there], yaw[there]])
    return DriveLog(
        source=file,
        reader="csv",
        projection=projection,
        pose=Samples(_time(table)[there], pose),
        fixes=_fixes(table, projector),
        speed=_column(table, _SPEED),
        yaw_rate=_column(table, _YAW_RATE),
        heading=_column(table, _HEADING),
        lane=_lane(table),
    )


def _read(file: Path) -> pd.DataFrame:
    """Return the cells as numbers, NaN where they are empty."""
    try:
        text = pd.read_csv(file, dtype=str, keep_default_na=False, encoding="utf-8-sig", skipinitialspace=True)
    except FileNotFoundError:
        raise GpsecError(f"{file}: no such log") from None
    except (OSError, UnicodeError, ValueError) as error:
        raise GpsecError(f"{file}: expected a table as CSV, found none: {shown(str(error).strip())}") from None
    for name in map(str, text.columns):
        if name not in LOG_COLUMNS:
            raise GpsecError(f"{file}: unknown column '{shown(name)}': {nearest(name, LOG_COLUMNS)}")
    if not len(text):
        raise GpsecError(f"{file}: expected rows below the header, found none")
    numbers = {str(name): _numbers(file, str(name), text[name]) for name in text.columns}
    return pd.DataFrame(numbers)


def _numbers(file: Path, name: str, cells: "pd.Series[str]") -> Floats:
    stripped = cells.str.strip()
    empty: Flags = (stripped == "").to_numpy()
    values: Floats = pd.to_numeric(stripped.where(~empty, "0"), errors="coerce").to_numpy(np.float64, copy=True)
    if len(wrong := np.flatnonzero(~np.isfinite(values))):
        raise GpsecError(
            f"{file}: row {wrong[0] + 2}, {name}: expected a number, found '{shown(cells.iloc[int(wrong[0])])}';"
            " a cell is left empty where there is none"
        )
    largest = _LARGEST.get(name, np.inf)
    if len(beyond := np.flatnonzero(np.abs(values) > largest + 1e-9)):
        unit = "radians; degrees have a column of their own" if name.endswith("_rad") else "degrees"
        raise GpsecError(
            f"{file}: row {beyond[0] + 2}, {name}: expected {-largest:.4g} to {largest:.4g}, in {unit}, found"
            f" {values[beyond[0]]:g}"
        )
    if name == TIME and empty.any():
        raise GpsecError(f"{file}: row {np.flatnonzero(empty)[0] + 2}, {name}: expected a time, found an empty cell")
    values[empty] = np.nan
    return values


def _check_columns(file: Path, names: set[str]) -> None:
    """Refuse columns that are missing, lack their partner, or say the same twice."""
    if TIME not in names:
        raise GpsecError(f"{file}: {TIME}: expected this column, found none")
    for prefix in ("", "fix_"):
        pairs = [tuple(prefix + name for name in pair) for pair in _POSITION]
        for pair in pairs:
            if len(names & set(pair)) == 1:
                missing = (set(pair) - names).pop()
                raise GpsecError(f"{file}: {missing}: expected this column beside its partner, found none")
        given = [pair for pair in pairs if names >= set(pair)]
        if len(given) > 1 or (not given and not prefix):
            found = "both" if given else "neither"
            raise GpsecError(
                f"{file}: expected {prefix}x_m and {prefix}y_m, or {prefix}lon_deg and {prefix}lat_deg, found {found}"
            )
    # Fixes on the Earth beside a pose that is nowhere on it cannot be compared.
    if "fix_lon_deg" in names and "lon_deg" not in names:
        raise GpsecError(f"{file}: fix_lon_deg: expected fix_x_m and fix_y_m, in the frame of x_m and y_m")
    if "fix_x_m" in names and "x_m" not in names:
        raise GpsecError(f"{file}: fix_x_m: expected fix_lon_deg and fix_lat_deg beside lon_deg and lat_deg")
    if names & set(_LANE[1:]) and _LANE[0] not in names:
        raise GpsecError(f"{file}: {_LANE[0]}: expected this column beside the others of the camera, found none")
    for ways in (_YAW, _HEADING, _YAW_RATE):
        if len(twice := sorted(names & set(ways))) > 1:
            raise GpsecError(f"{file}: expected one of {' and '.join(twice)}, found both")


def _time(table: pd.DataFrame) -> Floats:
    return table[TIME].to_numpy(np.float64)


def _metres(table: pd.DataFrame, names: tuple[str, ...], projector: Projector) -> Floats:
    values: Floats = table[list(names)].to_numpy(np.float64)
    return projector.from_lon_lat(values) if names[0].endswith("lon_deg") else values


def _one_of(table: pd.DataFrame, ways: dict[str, tuple[float, float]]) -> Floats | None:
    for name, (factor, zero) in ways.items():
        if name in table:
            values: Floats = zero + factor * table[name].to_numpy(np.float64)
            return values
    return None


def _column(table: pd.DataFrame, ways: dict[str, tuple[float, float]]) -> Samples | None:
    values = _one_of(table, ways)
    if values is None:
        return None
    there = ~np.isnan(values)
    return Samples(_time(table)[there], values[there, None])


def _fixes(table: pd.DataFrame, projector: Projector) -> Fixes | None:
    names = next((pair for pair in _POSITION if f"fix_{pair[0]}" in table), None)
    if names is None:
        return None
    given = tuple(f"fix_{name}" for name in names)
    there = table[list(given)].notna().all(axis=1).to_numpy()
    time_s = _time(table)[there]
    age_s = table["fix_age_s"].fillna(0.0).to_numpy(np.float64)[there] if "fix_age_s" in table else 0.0
    return Fixes(time_s, time_s - age_s, _metres(table, given, projector)[there])


def _lane(table: pd.DataFrame) -> Samples | None:
    if _LANE[0] not in table:
        return None
    there = table[_LANE[0]].notna().to_numpy()
    given = [table[name].fillna(0.0).to_numpy(np.float64) if name in table else np.zeros(len(table)) for name in _LANE]
    return Samples(_time(table)[there], np.column_stack(given)[there])
