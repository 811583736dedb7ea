"""Vehicles in a picture: boxes, of which one sees a side and the end that is turned to the camera."""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.scene import Moment, SeenBodies, in_frame_of

_FARTHEST_M, _NEAREST_M = 90.0, 0.4
_CAR_M, _TALL_M, _LONG_M = 1.5, 3.2, 6.5
_SHIFT = 4


class _Body(NamedTuple):
    """One vehicle in the frame of the camera's own: (4, 2) corners, rear ones first, height and key."""

    corners_m: Floats
    height_m: float
    key: int


def draw_bodies(picture: np.ndarray, camera: RoadCamera, moment: Moment, lit: float) -> None:
    """Draw the vehicles ahead into a (height, width, 3) picture, the nearest last; lights glow with `lit` 0 … 1."""
    for body in sorted(_ahead(moment), key=lambda body: -float(body.corners_m[:, 0].min())):
        _draw(picture, camera, body, lit)


def _ahead(moment: Moment) -> list[_Body]:
    others: SeenBodies = moment.others
    if not len(others.rear_m):
        return []
    at = in_frame_of(moment, others.rear_m)
    near = np.flatnonzero(
        (at[:, 0] > -15.0) & (at[:, 0] < _FARTHEST_M) & (np.abs(at[:, 1]) < 10.0 + at[:, 0].clip(0.0))
    )
    found = []
    for i in near.tolist():
        turn = float(others.yaw_rad[i]) - moment.yaw_rad
        front, rear, half = others.axle_m[i], others.axle_m[i] - others.length_m[i], 0.5 * others.width_m[i]
        own = np.array([[rear, half], [rear, -half], [front, -half], [front, half]])
        corners = at[i] + own @ np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]])
        height_m = _TALL_M if others.length_m[i] > _LONG_M else _CAR_M
        if corners[:, 0].max() > 2.5:
            found.append(_Body(corners, height_m, int(others.key[i])))
    return found


def _draw(picture: np.ndarray, camera: RoadCamera, body: _Body, lit: float) -> None:
    cv2 = opencv()
    beyond = camera.x_m + _NEAREST_M
    corners = body.corners_m.copy()
    corners[:, 0] = np.maximum(corners[:, 0], beyond)
    low, high = np.column_stack([corners, np.full(4, 0.25)]), np.column_stack([corners, np.full(4, body.height_m)])
    ground = np.column_stack([corners, np.zeros(4)])
    pixels, _ = camera.project(np.concatenate([low, high, ground]))
    pixels = np.clip(pixels, -4000.0, 4000.0)
    shade = np.array([40, 60, 90, 130, 180, 225])[body.key % 6]
    colour = (shade, shade, min(shade + 20 * (body.key // 6 % 3), 255))
    _fill(cv2, picture, cv2.convexHull(pixels[8:].astype(np.float32)).reshape(-1, 2), (18, 18, 18))
    _fill(
        cv2, picture, cv2.convexHull(pixels[:8].astype(np.float32)).reshape(-1, 2), tuple(int(0.7 * c) for c in colour)
    )
    # The end that is nearer: the rear of who drives ahead, the front of who comes towards.
    a, b = (0, 1) if corners[:2, 0].mean() < corners[2:, 0].mean() else (2, 3)
    if corners[[a, b], 0].min() <= beyond:
        return
    end = pixels[[a, b, b + 4, a + 4]]
    _fill(cv2, picture, end, colour)
    glass = np.concatenate([_between(end, 0.15, 0.6), _between(end, 0.15, 0.92)[::-1]])
    _fill(cv2, picture, glass, (35, 35, 35))
    wide = float(np.abs(end[1, 0] - end[0, 0]))
    for side in (0.1, 0.9):
        u, v = (1 - side) * end[0] + side * end[1] + 0.45 * (end[3] - end[0])
        light = (30, 30, int(120 + 135 * lit)) if (a, b) == (0, 1) else (int(140 + 115 * lit),) * 3
        cv2.circle(picture, (round(u * 16), round(v * 16)), max(round(wide), 8), light, -1, cv2.LINE_AA, _SHIFT)


def _between(end: Floats, margin: float, up: float) -> Floats:
    """Return two points across an end of a body, (2, 2), at a share of its height."""
    left, right = end[0] + up * (end[3] - end[0]), end[1] + up * (end[2] - end[1])
    return np.stack([left + margin * (right - left), right - margin * (right - left)])


def _fill(cv2: Any, picture: np.ndarray, corners: Floats, colour: tuple[int, ...]) -> None:
    points = np.round(corners * (1 << _SHIFT)).astype(np.int32)
    cv2.fillConvexPoly(picture, points, tuple(int(c) for c in colour), cv2.LINE_AA, _SHIFT)
