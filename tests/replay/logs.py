"""Small logs that tests make: a known drive, and sensors with known errors."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

RATE_HZ = 20.0


@dataclass(frozen=True)
class Way:
    """A drive at 15 m/s along a gentle S; all at 20 Hz."""

    time_s: np.ndarray
    east_m: np.ndarray
    north_m: np.ndarray
    yaw_rad: np.ndarray
    speed_mps: np.ndarray
    yaw_rate_rps: np.ndarray


def way(lasts_s: float = 40.0, speed_mps: float = 15.0) -> Way:
    time_s = np.arange(0.0, lasts_s + 0.5 / RATE_HZ, 1.0 / RATE_HZ)
    yaw_rate = 0.08 * np.sin(2.0 * np.pi * time_s / 20.0)
    yaw = 0.3 + 0.08 * 20.0 / (2.0 * np.pi) * (1.0 - np.cos(2.0 * np.pi * time_s / 20.0))
    step_m = speed_mps / RATE_HZ * np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    middle = np.vstack([np.zeros((1, 2)), np.cumsum(0.5 * (step_m[1:] + step_m[:-1]), axis=0)])
    return Way(time_s, middle[:, 0], middle[:, 1], yaw, np.full(len(time_s), speed_mps), yaw_rate)


def table(drive: Way | None = None, seed: int = 1) -> pd.DataFrame:
    """A CSV log's columns: fixes at 10 Hz off by (0.4, -0.3) m and 1 cm of noise, wheels 1 % too fast."""
    drive = drive or way()
    generator = np.random.default_rng(seed)
    found = pd.DataFrame({"t_s": drive.time_s, "x_m": drive.east_m, "y_m": drive.north_m, "yaw_rad": drive.yaw_rad})
    fixes = np.column_stack([drive.east_m + 0.4, drive.north_m - 0.3])
    fixes += 0.01 * generator.standard_normal(fixes.shape)
    fixes[1::2] = np.nan
    found["fix_x_m"], found["fix_y_m"] = fixes.T
    found["speed_mps"] = 1.01 * drive.speed_mps + 0.02 * generator.standard_normal(len(found))
    found["yaw_rate_rps"] = drive.yaw_rate_rps + 1e-3 * generator.standard_normal(len(found))
    return found


def write(columns: pd.DataFrame, path: Path) -> Path:
    columns.to_csv(path, index=False)
    return path


def csv_log(folder: Path, columns: pd.DataFrame | None = None) -> Path:
    return write(table() if columns is None else columns, folder / "drive.csv")


def comma_segment(folder: Path, drive: Way | None = None, flat: bool = False) -> Path:
    """A segment near 37.7° N, 122.5° W whose camera looks 1° to the left, with fixes 0.2 s late and 0.5 m north."""
    import pyproj

    drive = drive or way()
    lon0, lat0 = -122.47, 37.72
    frame = pyproj.CRS(f"+proj=tmerc +lat_0={lat0} +lon_0={lon0} +datum=WGS84 +units=m")
    back = pyproj.Transformer.from_crs(frame, "EPSG:4326", always_xy=True)
    to_centre = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    lon, lat = back.transform(drive.east_m, drive.north_m)
    positions = np.column_stack(to_centre.transform(lon, lat, np.full(len(lon), 30.0)))
    boot_s, utc_s = 1000.0, 1_533_226_488.0
    # GPS began on 6 January 1980, 315,964,800 s after the clock of UTC, and is 18 s ahead of it by now.
    week_s = (utc_s - 315_964_800.0 + 18.0) % 604_800.0
    fix = slice(0, None, 2)
    fix_lon, fix_lat = back.transform(drive.east_m[fix], drive.north_m[fix] + 0.5)
    fixes = np.column_stack(
        [fix_lat, fix_lon, drive.speed_mps[fix], 1e3 * (utc_s + drive.time_s[fix]), 0 * fix_lat, 0 * fix_lat]
    )
    still = np.zeros(len(drive.time_s))
    arrays = {
        "global_pose/frame_times": boot_s + drive.time_s,
        "global_pose/frame_gps_times": np.column_stack([still + 2012, week_s + drive.time_s]),
        "global_pose/frame_positions": positions,
        "global_pose/frame_orientations": _orientations(drive.yaw_rad + np.radians(1.0), lon0, lat0),
        "processed_log/GNSS/live_gnss_ublox/t": boot_s + drive.time_s[fix] + 0.2,
        "processed_log/GNSS/live_gnss_ublox/value": fixes,
        "processed_log/CAN/speed/t": boot_s + drive.time_s,
        "processed_log/CAN/speed/value": drive.speed_mps[:, None],
        "processed_log/IMU/gyro/t": boot_s + drive.time_s,
        "processed_log/IMU/gyro/value": np.column_stack([still, still, -drive.yaw_rate_rps]),
    }
    for name, array in arrays.items():
        path = folder / (f"{name.replace('/', '_')}.npy" if flat else name)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            np.save(file, array)
    return folder


def _orientations(yaw_rad: np.ndarray, lon_deg: float, lat_deg: float) -> np.ndarray:
    """Quaternions of a level frame (forward, right, down) that looks along `yaw_rad`."""
    from scipy.spatial.transform import Rotation

    lon, lat = np.radians([lon_deg, lat_deg])
    east = np.array([-np.sin(lon), np.cos(lon), 0.0])
    north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    up = np.cross(east, north)
    forward = np.cos(yaw_rad)[:, None] * east + np.sin(yaw_rad)[:, None] * north
    right = np.cross(forward, up)
    matrices = np.stack([forward, right, np.broadcast_to(-up, forward.shape)], axis=2)
    x, y, z, w = Rotation.from_matrix(matrices).as_quat().T
    return np.column_stack([w, x, y, z])
