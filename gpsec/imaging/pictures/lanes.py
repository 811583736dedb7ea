"""Lanes in pictures, in the paper's own order (II.A).

Calibration, region of interest, Gaussian filter, threshold, bird's eye, sliding windows, cubic fit.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.tables import taken
from gpsec.imaging.pictures.birdseye import BirdsEye, Marks
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.cubic import LineFit, fit_lane
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.search import find_lane
from gpsec.imaging.pictures.threshold import over_threshold, ridges
from gpsec.imaging.pictures.windows import slide

# Pictures are worked on at this width.
WORKING_WIDTH = 640
# What a lane must have to be believed: marks on each line, and on both together, within which spread. Where one line
# goes on for long and the width is known, a speck on the other one is enough.
_LEAST_PAINT_M, _ENOUGH_PAINT_M, _SPREAD_M, _SIGMA_M = 2.0, 5.0, 0.25, 0.4
_LONG_PAINT_M, _SPECK_M = 12.0, 0.5
# Without a width of the map: lanes of roads are so wide (m).
ANY_WIDTH_M = (2.6, 4.2)
WIDTH_GATE_M = 0.3


@dataclass(frozen=True)
class SeenLane:
    """What a picture says of the lane.

    Attributes:
        poly: (4,) C0 … C3 (Eq 1) at the rear axle, 0 where it says nothing.
        width_m: of the lane.
        sigma_m: standard deviation of C0 that is stated.
        valid: whether it says something.
        bends: whether the lane bends sharply, so that it is another curve some metres on.
    """

    poly: Floats
    width_m: float = 0.0
    sigma_m: float = 0.0
    valid: bool = False
    bends: bool = False


NO_LANE = SeenLane(np.zeros(4))


@dataclass(frozen=True)
class LaneFinder:
    """Finds the lane in the pictures of one camera; holds no state of a picture.

    Attributes:
        camera: as calibrated.
    """

    camera: RoadCamera
    _room: dict[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def birds_eye(self) -> BirdsEye:
        """The grid on the road."""
        return BirdsEye(self.camera.scaled(WORKING_WIDTH))

    def marks(self, picture: np.ndarray) -> Marks:
        """Return what is like paint in a (height, width, 3) picture: the steps up to the bird's eye."""
        cv2, eye = opencv(), self.birds_eye
        if picture.shape[1] != WORKING_WIDTH:
            picture = cv2.resize(picture, (eye.camera.width, eye.camera.height), interpolation=cv2.INTER_AREA)
        region = cv2.GaussianBlur(picture[eye.region], (5, 3), 0.0)
        bright, yellow = region[:, :, 2], cv2.subtract(region[:, :, 2], region[:, :, 0])
        if not self._room:
            self._room["found"] = np.zeros(bright.shape, np.int16)
            self._room["total"] = np.zeros((2, bright.shape[1] + 1), np.int32)
        ridges(np.ascontiguousarray(bright), yellow, eye.rows, self._room["total"], self._room["found"])
        return eye.marks(eye.seen_from_above(over_threshold(self._room["found"])))

    def find(self, picture: np.ndarray, width_m: float | None = None) -> SeenLane:
        """Return the lane in a picture; `width_m` is what the map says of it, if there is one."""
        return self.lane_of(self.marks(picture), width_m)

    def lane_of(self, marks: Marks, width_m: float | None = None) -> SeenLane:
        """Return the lane that marks on the road are of."""
        bounds = ANY_WIDTH_M if width_m is None else (width_m - WIDTH_GATE_M, width_m + WIDTH_GATE_M)
        pair = find_lane(marks, bounds)
        if pair is None:
            return NO_LANE
        left, right = (taken(marks, chosen) for chosen in slide(marks, pair))
        start = np.array([0.5 * (pair.left_m + pair.right_m), pair.turn, pair.bend, 0.0])
        expected = pair.left_m - pair.right_m if width_m is None else width_m
        fit = fit_lane(left, right, start, expected, 1.0 / self.birds_eye.camera.fx)
        if fit is None or not is_credible(fit, bounds, width_m is not None):
            return NO_LANE
        return SeenLane(fit.poly, fit.width_m, fit.sigma_m, True, fit.bends)


def is_credible(fit: LineFit, width_m: tuple[float, float], known: bool) -> bool:
    """Return whether a fit has enough paint on both lines, as wide apart as a lane, and lies where a vehicle can be.

    `width_m` bounds the width, which is `known` where they come of a map.
    """
    return (
        min(fit.paint_m) >= (_SPECK_M if known and max(fit.paint_m) >= _LONG_PAINT_M else _LEAST_PAINT_M)
        and sum(fit.paint_m) >= _ENOUGH_PAINT_M
        and width_m[0] <= fit.width_m <= width_m[1]
        and abs(fit.poly[0]) <= 0.5 * fit.width_m + 0.4
        and fit.spread_m <= _SPREAD_M
        and fit.sigma_m <= _SIGMA_M
    )
