"""Reads a segment of comma2k19 (Schafer et al. 2018): u-blox fixes, wheel speed, gyro, and a fused pose."""

from math import degrees, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.core.geo import Projector
from gpsec.replay.log import DriveLog, Fixes, Samples, projection_at

POSE = "global_pose/frame_positions"
# GPS began on 6 January 1980; since 2017 it has been 18 s ahead of UTC.
_GPS_EPOCH_S, _LEAP_S, _WEEK_S = 315_964_800.0, 18.0, 604_800.0
_LAT, _LON, _UTC_MS = 0, 1, 3
# Axes of the gyro: forward, right, down.
_DOWN = 2
# Slower than this, there is no course.
_MOVING_MPS = 5.0


def is_comma2k19(folder: Path) -> bool:
    """Return whether a folder is a segment."""
    return folder.is_dir() and _file(folder, POSE) is not None


def read_comma2k19(folder: Path) -> DriveLog:
    """Read a segment: its folder as in the data set, or all arrays in one, ``a/b/value`` as ``a_b_value.npy``.

    The pose is that of the camera; it stands for the rear axle, and fixes are compared with it as they are.

    Raises:
        GpsecError: an array is missing or broken.
    """
    ecef_m, quaternion = _array(folder, POSE, 3), _array(folder, "global_pose/frame_orientations", 4)
    time_s = _array(folder, "global_pose/frame_times", 0)
    if not len(time_s) == len(ecef_m) == len(quaternion):
        raise GpsecError(
            f"{folder}: global_pose: expected as many times, positions and orientations, found {len(time_s)},"
            f" {len(ecef_m)} and {len(quaternion)}"
        )
    lon_lat = _lon_lat(folder, ecef_m)
    projection = projection_at(*np.round(lon_lat[0], 7))
    east_north = Projector(projection, source=str(folder)).from_lon_lat(lon_lat)
    looks_rad = _yaw(quaternion, lon_lat[0])
    turned_rad = _turned_from_course(time_s, east_north, looks_rad)
    pose = Samples(time_s, np.column_stack([east_north, looks_rad - turned_rad]))
    return DriveLog(
        source=folder,
        reader="comma2k19",
        projection=projection,
        pose=pose,
        fixes=_fixes(folder, time_s, projection),
        speed=_samples(folder, "processed_log/CAN/speed", 1, 0),
        yaw_rate=_turned(_samples(folder, "processed_log/IMU/gyro", 3, _DOWN)),
        notes=(
            "the pose is that of the camera, and stands for the rear axle; its own error is in every figure",
            f"the camera looks {degrees(turned_rad):+.2f}° off the course, which is taken out of the yaw",
            *_missing(folder),
        ),
    )


def _missing(folder: Path) -> list[str]:
    if _file(folder, "processed_log/GNSS/live_gnss_ublox/value") is None:
        return []
    if _file(folder, "global_pose/frame_gps_times") is None:
        return ["there is no frame_gps_times: fixes are taken to be true when they arrive"]
    return []


def _fixes(folder: Path, frame_s: Floats, projection: str) -> Fixes | None:
    name = "processed_log/GNSS/live_gnss_ublox"
    if _file(folder, f"{name}/value") is None:
        return None
    arrived_s, values = _array(folder, f"{name}/t", 0), _array(folder, f"{name}/value", 6)
    if len(arrived_s) != len(values):
        raise GpsecError(
            f"{folder}: {name}: expected as many times as values, found {len(arrived_s)} and {len(values)}"
        )
    position_m = Projector(projection, source=str(folder)).from_lon_lat(values[:, [_LON, _LAT]])
    valid_s = arrived_s
    if _file(folder, "global_pose/frame_gps_times") is not None:
        of_week_s = _array(folder, "global_pose/frame_gps_times", 2)[:, 1]
        # From the week's beginning to the log's clock: frames have both.
        shift_s = float(np.median(frame_s[: len(of_week_s)] - of_week_s[: len(frame_s)]))
        valid_s = (values[:, _UTC_MS] / 1e3 - _GPS_EPOCH_S + _LEAP_S) % _WEEK_S + shift_s
    return Fixes(arrived_s, valid_s, position_m)


def _samples(folder: Path, name: str, width: int, column: int) -> Samples | None:
    if _file(folder, f"{name}/value") is None:
        return None
    time_s, values = _array(folder, f"{name}/t", 0), _array(folder, f"{name}/value", width)
    if len(time_s) != len(values):
        raise GpsecError(f"{folder}: {name}: expected as many times as values, found {len(time_s)} and {len(values)}")
    return Samples(time_s, values[:, column : column + 1])


def _turned(samples: Samples | None) -> Samples | None:
    """Return a yaw rate about the axis that points up."""
    return None if samples is None else Samples(samples.time_s, -samples.numbers)


def _lon_lat(folder: Path, ecef_m: Floats) -> Floats:
    import pyproj  # late: it takes long

    away_m = np.linalg.norm(ecef_m, axis=1)
    if not (np.isfinite(away_m).all() and (np.abs(away_m - 6.37e6) < 1e5).all()):
        raise GpsecError(f"{folder}: {POSE}: expected metres from the Earth's centre (ECEF), found other values")
    to_earth = pyproj.Transformer.from_crs("EPSG:4978", "EPSG:4979", always_xy=True)
    return np.column_stack(to_earth.transform(*ecef_m.T)[:2])


def _yaw(quaternion: Floats, origin_deg: Floats) -> Floats:
    """Return (n,) the direction of the first axis of (n, 4) rotations to ECEF, counter-clockwise from east."""
    w, x, y, z = quaternion.T
    forward = np.stack([w * w + x * x - y * y - z * z, 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)], axis=1)
    lon, lat = np.radians(origin_deg)
    east = np.array([-np.sin(lon), np.cos(lon), 0.0])
    north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    yaw: Floats = np.arctan2(forward @ north, forward @ east)
    return yaw


def _turned_from_course(time_s: Floats, east_north_m: Floats, yaw_rad: Floats) -> float:
    """Return by how much the camera looks to the left of where the vehicle goes, in the median; 0 where it stands."""
    way_m = np.diff(east_north_m, axis=0)
    moving = np.hypot(*way_m.T) > _MOVING_MPS * np.maximum(np.diff(time_s), 1e-6)
    if moving.sum() < 20:
        return 0.0
    off = yaw_rad[1:] - np.arctan2(way_m[:, 1], way_m[:, 0])
    return float(np.median(((off + pi) % (2.0 * pi) - pi)[moving]))


def _file(folder: Path, name: str) -> Path | None:
    """Return where an array lies, None where it does not."""
    group, _, rest = name.partition("/")
    flat = f"{name.replace('/', '_')}.npy"
    for path in (folder / name, folder / group / f"{rest}.npy", folder / flat):
        if path.is_file():
            return path
    return None


def _array(folder: Path, name: str, width: int) -> Floats:
    """Return an array of numbers with rows of a width, 0 for an array of one axis."""
    path = _file(folder, name)
    if path is None:
        raise GpsecError(f"{folder}: {name}: expected this array of a comma2k19 segment, found none")
    try:
        array: NDArray[np.float64] = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError, SyntaxError, MemoryError) as error:
        raise GpsecError(f"{path}: expected an array of numpy, found a broken file: {shown(error)}") from None
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
        raise GpsecError(f"{path}: expected an array of numbers, found something else")
    rows = array.reshape(len(array), -1) if array.ndim else array.reshape(1, 1)
    if rows.shape[1] != max(width, 1):
        raise GpsecError(f"{path}: expected rows of {max(width, 1)} numbers, found {rows.shape[1]}")
    plain = np.ascontiguousarray(rows, np.float64)
    return plain[:, 0] if width == 0 else plain
