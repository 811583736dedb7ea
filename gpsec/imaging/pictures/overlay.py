"""Pictures with the lane that was found drawn into them."""

import numpy as np

from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.lanes import SeenLane
from gpsec.imaging.pictures.opencv import opencv

_FAR_M = 40.0
# Okabe and Ito's sky blue and vermilion.
_LINE, _CENTRE = (233, 180, 86), (0, 94, 213)


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
