"""Pictures with the lane that was found drawn into them."""

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.lanes import SeenLane
from gpsec.imaging.pictures.opencv import opencv

_FAR_M = 40.0
# Okabe and Ito's sky blue and vermilion.
_LINE, _CENTRE = (233, 180, 86), (0, 94, 213)

OVERLAYS = ("none", "pictures", "video", "animation")
"""What pictures with their lanes are kept as."""
# An animation is for pages: so wide, so many pictures a second at most, and so good.
_ANIMATED_PX, _ANIMATED_HZ, _ANIMATED_QUALITY = 400, 5.0, 45


def overlaid(picture: np.ndarray, camera: RoadCamera, lane: SeenLane) -> np.ndarray:
    """Return a copy of a picture with both lines, the centre and C0 of a lane, or with the word that there is none."""
    cv2 = opencv()
    drawn = picture.copy()
    size = camera.width / 640.0
    if lane.valid:
        x = np.linspace(camera.x_m + 2.5, _FAR_M, 60)
        centre = np.polynomial.polynomial.polyval(x, lane.poly)
        norm = np.sqrt(1.0 + np.polynomial.polynomial.polyval(x, np.polynomial.polynomial.polyder(lane.poly)) ** 2)
        for side, colour in ((0.5, _LINE), (-0.5, _LINE), (0.0, _CENTRE)):
            y = centre + side * lane.width_m * norm
            pixels, depth = camera.project(np.stack([x, y, np.zeros(len(x))], axis=1))
            line = np.round(pixels[depth > 0.5].clip(-1e4, 1e4) * 16.0).astype(np.int32)
            cv2.polylines(drawn, [line], False, colour, max(round(2 * size), 1), cv2.LINE_AA, 4)
    said = f"C0 {lane.poly[0]:+.2f} m, sigma {lane.sigma_m:.2f} m" if lane.valid else "no lane"
    cv2.rectangle(drawn, (0, 0), (round(230 * size), round(32 * size)), (40, 40, 40), -1)
    at = (round(8 * size), round(22 * size))
    cv2.putText(
        drawn, said, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5 * size, (255, 255, 255), max(round(size), 1), cv2.LINE_AA
    )
    return drawn


class Drawn:
    """Keeps pictures with the lane in them: as files, as a video (MP4), or as an animation (WebP), which pages show."""

    def __init__(self, folder: Path, camera: RoadCamera, rate_hz: float, kind: str) -> None:
        self._folder, self._camera, self._kind = folder, camera, kind
        self._every = max(round(rate_hz / _ANIMATED_HZ), 1)
        self._rate_hz = rate_hz
        self._frames: list[np.ndarray] = []
        self._count = 0
        self._video: Any = None

    def __enter__(self) -> Self:
        if self._kind == "video":
            cv2, path, camera = opencv(), self._folder / "lanes.mp4", self._camera
            code = cv2.VideoWriter_fourcc(*"mp4v")
            self._video = cv2.VideoWriter(str(path), code, self._rate_hz, (camera.width, camera.height))
            if not self._video.isOpened():
                raise GpsecError(f"{path}: no video can be written there; take --overlay pictures")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._video is not None:
            self._video.release()
        if self._frames and error is None:
            self._animate()

    def add(self, name: str, picture: np.ndarray, seen: SeenLane) -> None:
        """Keep one more."""
        number, self._count = self._count, self._count + 1
        if self._kind == "none" or (self._kind == "animation" and number % self._every):
            return
        drawn = overlaid(picture, self._camera, seen)
        if self._video is not None:
            self._video.write(drawn)
        elif self._kind == "animation":
            height = round(_ANIMATED_PX * self._camera.height / self._camera.width)
            area = opencv().INTER_AREA
            self._frames.append(opencv().resize(drawn, (_ANIMATED_PX, height), interpolation=area))
        else:
            path = self._folder / f"lane-{Path(name).stem}.png"
            if not opencv().imwrite(str(path), drawn):
                raise GpsecError(f"{path}: the picture cannot be written")

    def _animate(self) -> None:
        cv2, path = opencv(), self._folder / "lanes.webp"
        film = cv2.Animation()
        film.frames = self._frames
        film.durations = [round(1000.0 * self._every / self._rate_hz)] * len(self._frames)
        if not cv2.imwriteanimation(str(path), film, [cv2.IMWRITE_WEBP_QUALITY, _ANIMATED_QUALITY]):
            raise GpsecError(f"{path}: no animation can be written there; take --overlay pictures")
