"""Pictures of a folder or of a video, one after the other, each with its time."""

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gpsec.core.errors import GpsecError, shown
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.opencv import opencv

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".ppm", ".tif", ".tiff")
TRUTH = "truth.csv"
"""What `gpsec image render` writes beside its pictures: the time and the way of each."""


class Shot(NamedTuple):
    """One picture.

    Attributes:
        name: file, or number in the video.
        time_s: since the first one of a video; of the simulation, where the folder says.
        picture: (height, width, 3), blue, green, red.
        moved: metres and radians since the picture before, None where nothing says.
    """

    name: str
    time_s: float
    picture: np.ndarray
    moved: tuple[float, float] | None


@dataclass(frozen=True)
class Frames:
    """A folder of pictures, in the order of their names, or a video.

    Attributes:
        path: of either.
        rate_hz: pictures a second.
        count: how many there are; a video's may be an estimate of its container.
    """

    path: Path
    rate_hz: float
    count: int

    def shots(self, camera: RoadCamera | None = None) -> Iterator[Shot]:
        """Yield the pictures; with a `camera`, they must be of its size.

        Raises:
            GpsecError: one cannot be read, or has another size.
        """
        found = self._of_folder() if self.path.is_dir() else self._of_video()
        for shot in found:
            height, width = shot.picture.shape[:2]
            if camera is not None and (width, height) != (camera.width, camera.height):
                raise GpsecError(
                    f"{self.path}: {shown(shot.name)}: expected {camera.width} x {camera.height} pixels as in the "
                    f"calibration, found {width} x {height}"
                )
            yield shot

    def _of_folder(self) -> Iterator[Shot]:
        ways = _ways(self.path / TRUTH)
        for number, file in enumerate(_files(self.path)):
            time_s, moved = ways.get(file.name, (number / self.rate_hz, None))
            yield Shot(file.name, time_s, read_picture(file), moved)

    def _of_video(self) -> Iterator[Shot]:
        video = opencv().VideoCapture(str(self.path))
        number = 0
        while True:
            whole, picture = video.read()
            if not whole:
                break
            yield Shot(str(number), number / self.rate_hz, picture, None)
            number += 1
        video.release()
        if not number:
            raise GpsecError(f"{self.path}: expected a video with frames, found none that can be read")


def open_frames(path: Path, rate_hz: float | None = None) -> Frames:
    """Return the pictures of a folder, of one file, or of a video; `rate_hz` is needed where nothing says it.

    Raises:
        GpsecError: there are none.
    """
    if path.is_dir():
        files = _files(path)
        if not files:
            raise GpsecError(f"{path}: expected pictures ({', '.join(PICTURES)}), found none")
        return Frames(path, rate_hz or 10.0, len(files))
    if not path.is_file():
        raise GpsecError(f"{path}: no such folder or video")
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # what it complains of is said in a sentence
    cv2 = opencv()
    video = cv2.VideoCapture(str(path))
    rate, count = float(video.get(cv2.CAP_PROP_FPS)), int(video.get(cv2.CAP_PROP_FRAME_COUNT))
    is_open = video.isOpened()
    video.release()
    if not is_open or count == 0:
        raise GpsecError(f"{path}: expected a video with frames, found none that can be read")
    return Frames(path, rate_hz or (rate if 0.0 < rate < 1e4 else 25.0), max(count, 0))


def read_picture(path: Path) -> np.ndarray:
    """Return the (height, width, 3) picture in a file.

    Raises:
        GpsecError: it cannot be read.
    """
    cv2 = opencv()
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
        picture = cv2.imdecode(content, cv2.IMREAD_COLOR) if len(content) else None
    except (OSError, cv2.error):
        picture = None
    if picture is None:
        raise GpsecError(f"{path}: expected a picture, found a file that cannot be read as one")
    read: np.ndarray = picture
    return read


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in PICTURES)


def _ways(path: Path) -> dict[str, tuple[float, tuple[float, float] | None]]:
    """Return name -> time and way since the picture before, as rendered frames say it."""
    if not path.is_file():
        return {}
    ways: dict[str, tuple[float, tuple[float, float] | None]] = {}
    last: float | None = None
    with path.open(newline="", encoding="utf-8") as file:
        for number, row in enumerate(csv.DictReader(file), start=2):
            try:
                time_s, speed, turn = (float(row[key]) for key in ("t_s", "speed_mps", "yaw_rate_rps"))
            except (KeyError, TypeError, ValueError):
                raise GpsecError(f"{path}: row {number}: expected numbers in t_s, speed_mps, yaw_rate_rps") from None
            if last is not None and time_s <= last:
                raise GpsecError(f"{path}: row {number}: t_s: expected more than {last:g}, found {time_s:g}")
            span_s = 0.0 if last is None else time_s - last
            ways[str(row.get("frame"))] = time_s, None if last is None else (speed * span_s, turn * span_s)
            last = time_s
    return ways
