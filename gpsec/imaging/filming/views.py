"""What the camera of a vehicle in traffic shows, and what is true of it: pictures and truth into a folder."""

import csv
from collections.abc import Callable
from pathlib import Path

from gpsec.core.errors import GpsecError
from gpsec.imaging.filming.film import Film
from gpsec.imaging.pictures.calibration import write_calibration
from gpsec.imaging.pictures.folder import filled_folder
from gpsec.imaging.pictures.frames import TRUTH
from gpsec.imaging.pictures.mounting import camera_on, misaligned
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.paint import paint_roads
from gpsec.imaging.pictures.render import Renderer
from gpsec.imaging.pictures.weather import Weather

_COLUMNS = ("frame", "t_s", "c0_m", "c1", "c2_per_m", "c3_per_m2", "width_m", "marked", "speed_mps", "yaw_rate_rps")


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
            table.writerow(_COLUMNS)
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
