"""Pictures side by side, each with the lane that was found in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.calibration import read_calibration
from gpsec.imaging.pictures.frames import PICTURES, read_picture
from gpsec.imaging.pictures.lanes import LaneFinder
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.overlay import overlaid

CALIBRATION = "calibration.json"
_GAP, _TITLE = 6, 26
_PAPER, _INK = (255, 255, 255), (40, 40, 40)


@dataclass(frozen=True)
class Panel:
    """One picture of a figure.

    Attributes:
        title: below it.
        picture: its file; `calibration.json` beside it is of its camera.
    """

    title: str
    picture: Path

    @classmethod
    def of(cls, text: str) -> "Panel":
        """Return the panel of an argument, ``PICTURE`` or ``TITLE=PICTURE``."""
        title, equals, path = text.partition("=")
        return cls(title, Path(path)) if equals else cls(Path(text).parent.name or Path(text).stem, Path(text))

    def drawn(self, width: int, lane_width_m: float | None) -> np.ndarray:
        """Return the picture with its lane, resized to `width`, and its title below.

        Raises:
            GpsecError: the picture or its calibration cannot be read, or they are of different sizes.
        """
        cv2 = opencv()
        camera, picture = read_calibration(self.picture.parent / CALIBRATION), read_picture(self.picture)
        if picture.shape[1::-1] != (camera.width, camera.height):
            raise GpsecError(
                f"{self.picture}: expected {camera.width} x {camera.height} pixels as in {CALIBRATION} beside it, found"
                f" {picture.shape[1]} x {picture.shape[0]}"
            )
        lane = LaneFinder(camera).find(picture, lane_width_m)
        height = round(width * camera.height / camera.width)
        panel = np.full((height + _TITLE, width, 3), _PAPER, np.uint8)
        panel[:height] = cv2.resize(overlaid(picture, camera, lane), (width, height), interpolation=cv2.INTER_AREA)
        cv2.putText(
            panel, self.title, (4, height + 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _INK, 1, cv2.LINE_AA
        )  # OpenCV's letters are those of ASCII
        return panel


def write_figure(
    panels: Sequence[Panel], path: Path, *, columns: int, width: int, lane_width_m: float | None = None
) -> None:
    """Write the panels into one picture, `columns` in a row, each `width` pixels wide.

    Raises:
        GpsecError: a picture cannot be read, or the figure cannot be written.
    """
    if path.suffix.lower() not in PICTURES:
        raise GpsecError(f"--out: expected a name that ends in {', '.join(PICTURES)}, found '{path.name}'")
    drawn = [panel.drawn(width, lane_width_m) for panel in panels]
    rows = [drawn[first : first + columns] for first in range(0, len(drawn), columns)]
    tall = [max(len(panel) for panel in row) for row in rows]
    across = min(columns, len(drawn))
    figure = np.full((sum(tall), across * width + (across - 1) * _GAP, 3), _PAPER, np.uint8)
    top = 0
    for row, height in zip(rows, tall, strict=True):
        for number, panel in enumerate(row):
            left = number * (width + _GAP)
            figure[top : top + len(panel), left : left + width] = panel
        top += height
    if not opencv().imwrite(str(path), figure, [opencv().IMWRITE_JPEG_QUALITY, 88]):
        raise GpsecError(f"{path}: the figure cannot be written there")
