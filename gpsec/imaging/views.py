"""What the camera of a vehicle in traffic shows, and what is true of it: pictures and truth into a folder."""

import csv
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.imaging.calibration import write_calibration
from gpsec.imaging.camera import RoadCamera
from gpsec.imaging.film import Film
from gpsec.imaging.frames import TRUTH
from gpsec.imaging.opencv import opencv
from gpsec.imaging.paint import paint_roads
from gpsec.imaging.render import Renderer
from gpsec.imaging.weather import Weather

_COLUMNS = ("frame", "t_s", "c0_m", "c1", "c2_per_m", "c3_per_m2", "width_m", "marked", "speed_mps", "yaw_rate_rps")
# Behind the windscreen: so far ahead of the rear axle of a car, and behind the front of whatever is longer.
_AHEAD_M, _BEHIND_FRONT_M = 1.7, 1.9


def camera_on(axle_m: float) -> RoadCamera:
    """Return the camera of a vehicle whose front bumper is `axle_m` ahead of its rear axle."""
    return RoadCamera(x_m=max(_AHEAD_M, axle_m - _BEHIND_FRONT_M))


def misaligned(camera: RoadCamera, key: int, error_deg: float) -> RoadCamera:
    """Return the camera as it is mounted on the vehicle `key`, off by `error_deg` (σ) on each axis."""
    roll, pitch, yaw = np.random.default_rng([key, 11]).normal(0.0, error_deg, 3).tolist() if error_deg else (0.0,) * 3
    return camera.turned(roll, pitch, yaw)


def render_view(
    film: Film, name: str, weather: Weather, error_deg: float, folder: Path, tell: Callable[[int, int], None]
) -> int:
    """Write the pictures that a vehicle's camera shows, what is true in each, and the calibration; return their number.

    `truth.csv` has a row a picture: time, C0 … C3 of Eq 1, width of the lane, whether it is marked, speed and yaw rate.

    Raises:
        GpsecError: the vehicle is not in the film, or the folder cannot be written.
    """
    rows = film.rows_of(name)
    who = int(film.vehicle[rows[0]])
    camera = camera_on(float(film.axle_m[who]))
    key = int(film.key[who])
    renderer = Renderer(misaligned(camera, key, error_deg), paint_roads(film.hd_map, 0), weather, key)
    with filled_folder(folder) as part:
        write_calibration(camera, part / "calibration.json")
        with (part / TRUTH).open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(
                [
                    "frame",
                    "t_s",
                    "c0_m",
                    "c1",
                    "c2_per_m",
                    "c3_per_m2",
                    "width_m",
                    "marked",
                    "speed_mps",
                    "yaw_rate_rps",
                ]
            )
            for number, row in enumerate(rows.tolist()):
                picture = renderer.picture(film.moment(row))
                file_name = f"{number:05d}.png"
                if not opencv().imwrite(str(part / file_name), picture):
                    raise GpsecError(f"{part / file_name}: the picture cannot be written")
                width_m = float(film.hd_map.sides.width_m[film.lane[row]])
                time_s = float(film.time_s[film.moment_of(row)])
                truth = [f"{value:.6g}" for value in film.truth[row].tolist()]
                motion = [f"{of[row]:.6g}" for of in (film.speed_mps, film.yaw_rate_rps)]
                table.writerow([file_name, f"{time_s:.3f}", *truth, f"{width_m:g}", int(film.marked[row]), *motion])
                tell(number + 1, len(rows))
    return len(rows)


@contextmanager
def filled_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to fill, which takes the name `folder` once the block has succeeded.

    Raises:
        GpsecError: there is something of that name already, or it cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise GpsecError(f"{folder}: expected a folder that is not there yet or empty; choose another --out")
    with in_a_sentence(f"{folder}: no folder can be written there"):
        part = folder.with_name(f".{folder.name}.part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        try:
            yield part
            if folder.exists():
                folder.rmdir()
            part.rename(folder)
        finally:
            shutil.rmtree(part, ignore_errors=True)
