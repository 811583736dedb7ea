"""Calibration: the lens by pictures of a chessboard (Zhang 2000), the mounting by frames of a straight road.

On a straight lane both lines meet in the vanishing point of the vehicle's way, which gives pitch and yaw; how far they
are apart gives the height, if one knows the width of the lane. Roll, and where in the vehicle the camera is, cannot be
seen: they are taken as given.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from math import atan, cos, degrees
from typing import NamedTuple

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.birdseye import Marks
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.frames import Shot
from gpsec.imaging.pictures.lanes import WORKING_WIDTH, LaneFinder
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.search import LanePair, find_lane
from gpsec.imaging.pictures.windows import slide

# Pitches that are tried until lines are parallel, and widths of a lane before the height is known (m).
_PITCHES_DEG = np.arange(-6.0, 12.1, 0.5)
_WIDTHS_M = (2.2, 5.6)
_ROUNDS = 4
# Votes (metres of marks) that both lines of a straight frame must have.
_LEAST_VOTES = 2.0


class Lens(NamedTuple):
    """What chessboards give.

    Attributes:
        camera: intrinsics and distortion; how it is mounted is not known.
        boards: how many were found.
        error_px: root mean square of corners about where they are expected.
        left_out: names of pictures without a whole board, or of another size.
    """

    camera: RoadCamera
    boards: int
    error_px: float
    left_out: list[str]


def lens_of(shots: Sequence[Shot], corners: tuple[int, int]) -> Lens:
    """Return intrinsics and distortion by pictures of a chessboard with so many inner corners a row and a column.

    Raises:
        GpsecError: fewer than three whole boards are found.
    """
    cv2 = opencv()
    sizes = Counter((shot.picture.shape[1], shot.picture.shape[0]) for shot in shots)
    (width, height), _ = sizes.most_common(1)[0]
    board = np.zeros((corners[0] * corners[1], 3), np.float32)
    board[:, :2] = np.mgrid[0 : corners[0], 0 : corners[1]].T.reshape(-1, 2)
    found, left_out = [], []
    for shot in shots:
        grey = cv2.cvtColor(shot.picture, cv2.COLOR_BGR2GRAY)
        whole, at = cv2.findChessboardCorners(grey, corners)
        if not whole or grey.shape != (height, width):
            left_out.append(shot.name)
            continue
        stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
        found.append(cv2.cornerSubPix(grey, at, (7, 7), (-1, -1), stop))
    if len(found) < 3:
        raise GpsecError(
            f"--boards: expected at least 3 pictures with a whole chessboard of {corners[0]} x {corners[1]} inner "
            f"corners, found {len(found)} of {len(shots)}"
        )
    error_px, matrix, distortion, _, _ = cv2.calibrateCamera([board] * len(found), found, (width, height), None, None)
    k1, k2, p1, p2, k3 = (float(value) for value in np.ravel(distortion)[:5])
    camera = RoadCamera(
        width=width,
        height=height,
        fx=float(matrix[0, 0]),
        fy=float(matrix[1, 1]),
        cx=float(matrix[0, 2]),
        cy=float(matrix[1, 2]),
        distortion=(k1, k2, p1, p2, k3),
        hood_row=height,
    )
    return Lens(camera, len(found), float(error_px), left_out)


def mounted(camera: RoadCamera, shots: Sequence[Shot], lane_width_m: float) -> RoadCamera:
    """Return the camera with pitch, yaw and height by frames in which the vehicle drives along a straight lane.

    Raises:
        GpsecError: no lane is found in them.
    """
    found = [one for shot in shots if (one := _mounted_by(camera, shot, lane_width_m)) is not None]
    if not found:
        raise GpsecError(f"--straight: expected frames of a straight lane with both lines, found none of {len(shots)}")
    pitch_deg, yaw_deg, z_m = np.median([(one.pitch_deg, one.yaw_deg, one.z_m) for one in found], axis=0).tolist()
    return replace(camera, pitch_deg=round(pitch_deg, 3), yaw_deg=round(yaw_deg, 3), z_m=round(z_m, 3))


def _mounted_by(camera: RoadCamera, shot: Shot, lane_width_m: float) -> RoadCamera | None:
    tried = [replace(camera, pitch_deg=float(pitch), yaw_deg=0.0) for pitch in _PITCHES_DEG]
    best = max(tried, key=lambda one: _votes(one, shot))
    if _votes(best, shot) < _LEAST_VOTES:
        return None
    for _ in range(_ROUNDS):
        lines = _lines(best, shot)
        if lines is None:
            return None
        best = _turned_to(best, lines, lane_width_m)
    return best


def _votes(camera: RoadCamera, shot: Shot) -> float:
    pair, _ = _pair(camera, shot)
    straight = pair is not None and pair.bend == 0.0
    return min(pair.left_votes, pair.right_votes) if pair is not None and straight else 0.0


def _pair(camera: RoadCamera, shot: Shot) -> tuple[LanePair | None, Marks]:
    finder = LaneFinder(camera)
    if finder.birds_eye.region.stop - finder.birds_eye.region.start < 20:
        return None, Marks(*(np.zeros(0) for _ in Marks._fields))
    marks = finder.marks(shot.picture)
    return find_lane(marks, _WIDTHS_M), marks


def _lines(camera: RoadCamera, shot: Shot) -> list[np.ndarray] | None:
    """Return both lines as (2,) coefficients of x = a·y + b, of pixels less the principal point, over focal length."""
    pair, marks = _pair(camera, shot)
    if pair is None:
        return None
    scaled = camera.scaled(WORKING_WIDTH)
    ideal = replace(scaled, distortion=(0.0,) * 5)
    lines = []
    for chosen in slide(marks, pair):
        if chosen.sum() < 5:
            return None
        at = np.stack([marks.x_m[chosen], marks.y_m[chosen], np.zeros(chosen.sum())], axis=1)
        pixels, _ = ideal.project(at)
        x, y = (pixels[:, 0] - ideal.cx) / ideal.fx, (pixels[:, 1] - ideal.cy) / ideal.fy
        slope, start = np.polyfit(y, x, 1, w=np.sqrt(marks.strength[chosen]))
        rest = np.abs(slope * y + start - x)
        near = rest <= 3.0 * np.median(rest) + 1e-6
        lines.append(np.polyfit(y[near], x[near], 1))
    return lines


def _turned_to(camera: RoadCamera, lines: Sequence[np.ndarray], lane_width_m: float) -> RoadCamera:
    """Return the camera that looks at the vanishing point of two lines as a vehicle's way, and as high as they say."""
    (a1, b1), (a2, b2) = lines
    y = (b2 - b1) / (a1 - a2)
    x = a1 * y + b1
    pitch = -atan(y)
    yaw = atan(x * cos(pitch))
    turned = replace(camera, pitch_deg=degrees(pitch), yaw_deg=degrees(yaw), z_m=1.0)
    # Both lines on the road of a camera that is 1 m high, at two rows below the vanishing point.
    ideal = replace(turned, width=2, height=2, fx=1.0, fy=1.0, cx=0.0, cy=0.0, distortion=(0.0,) * 5)
    rows = y + np.array([0.08, 0.2])
    sides = [ideal.on_road(np.stack([a * rows + b, rows], axis=1))[:, 1] for a, b in lines]
    wide = float(np.mean(np.abs(sides[0] - sides[1])))
    return replace(turned, z_m=lane_width_m / wide)
