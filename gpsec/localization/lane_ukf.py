"""The UKF of `ukf5`: the camera's lane offset and lane direction correct all that is left when GNSS is isolated.

State: east, north, yaw, scale error of the odometer, bias of the gyro, and the slow error of the camera's offset.
2N + 1 = 13 sigma points; those of the last three states have the position and yaw of the mean, so that seven are
matched. Weights are Merwe's with α = 1, β = 2, κ = 0: none is negative, as κ = 3 - n would make that of the mean.
"""

from math import cos, sqrt, tan
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.hdmap.around import gather_around, nearest_of
from gpsec.hdmap.arrays import MapArrays, MatchIndex, Pose
from gpsec.hdmap.matching import view_on
from gpsec.hdmap.search import MIN_COS, TRACKED, match
from gpsec.localization.learning import GYRO, SCALE, SLOW
from gpsec.localization.noise import FilterNoise
from gpsec.localization.ukf import NEAR

ACTIVE = 6
# Where the active states are in the filter state: those that a sigma point is matched with come first.
_AT = (0, 1, 2, SCALE, GYRO, SLOW)
_CAMERA = 5
# n + λ, weight of each point but the mean, and weight of the mean in covariances (in means it is 0).
SPREAD, WEIGHT, CENTRE_WEIGHT = 6.0, 1.0 / 12.0, 2.0


class Room(NamedTuple):
    """Room to work in: (6, 6) root of the covariance, (7, 2) what matched points expect, and their segments."""

    root: Floats
    expected: Floats
    near: Ints


def room() -> Room:
    """Return room for one thread."""
    return Room(np.empty((ACTIVE, ACTIVE)), np.empty((7, 2)), np.empty(NEAR, np.int32))


@inline
def camera_noise(table: FilterNoise[Floats], profile: int, stated_m: float) -> tuple[float, float]:
    """Return σ of the white parts of C0 and of C1, from the σ that the camera states for C0.

    What is stated includes the slow errors. A shorter view r of the lane makes the white part of C0 grow with r^(-1/2),
    that of C1 with r^(-3/2).
    """
    slow = table.camera_bias_m[profile] ** 2 + table.camera_mount_m[profile] ** 2
    full = table.camera_white_m[profile]
    white = sqrt(max(stated_m * stated_m - slow, full * full))
    ratio = white / full if full > 0.0 else 1.0
    return white, table.camera_slope[profile] * ratio * ratio * ratio


@inline
def _root(root: Floats, P: Floats) -> int:
    """Set the upper Cholesky factor of (n + λ) P; returns repairs made."""
    repairs = 0
    for k in range(ACTIVE):
        for j in range(k, ACTIVE):
            total = SPREAD * P[_AT[k], _AT[j]]
            for m in range(k):
                total -= root[m, k] * root[m, j]
            if j > k:
                root[k, j] = total / root[k, k] if root[k, k] > 0.0 else 0.0
            elif total > 0.0:
                root[k, k] = sqrt(total)
            else:
                root[k, k] = 0.0
                # A state that is known exactly is no fault; below zero by more than rounding is one.
                if total < -1e-12:
                    P[_AT[k], _AT[k]] -= total / SPREAD
                    repairs += 1
    return repairs


@inline
def update(
    mean: Floats,
    covariance: Floats,
    room: Room,
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: int,
    lane: int,
    hint: int,
    offset_m: float,
    slope: float,
    offset_sigma_m: float,
    slope_sigma: float,
) -> tuple[int, int]:
    """Correct with the camera's lane offset (-C0) and the slope of the lane in the vehicle's frame (C1).

    Returns the segment of the mean (-1 where a sigma point had no match; nothing is corrected then) and repairs made.
    """
    P = covariance
    root = room.root
    expected = room.expected
    repairs = _root(root, P)
    segment = hint
    count = -1
    if mode == TRACKED:
        reach = max(sqrt(root[0, 0] * root[0, 0] + root[0, 1] * root[0, 1]), root[1, 1])
        pose = Pose(layer, lane, mean[0], mean[1], mean[2])
        count, segment = gather_around(lanes, index, pose, hint, reach, room.near)
    centre = -1
    for point in range(7):
        x = mean[0]
        y = mean[1]
        yaw = mean[2]
        if point > 0:
            k = (point - 1) // 2
            sign = 1.0 if point % 2 == 1 else -1.0
            x += sign * root[k, 0] if k == 0 else 0.0
            y += sign * root[k, 1] if k < 2 else 0.0
            yaw += sign * root[k, 2]
        if count > 0:
            segment = nearest_of(lanes, room.near, count, x, y)
        else:
            segment = match(lanes, index, mode, Pose(layer, lane, x, y, yaw), segment)
        if segment < 0:
            return -1, repairs
        offset, turn = view_on(lanes, segment, x, y, yaw, mode == TRACKED)
        if abs(cos(turn)) < MIN_COS:
            return -1, repairs
        expected[point, 0] = offset
        expected[point, 1] = tan(turn)
        if point == 0:
            centre = segment
    z0 = WEIGHT * (ACTIVE * expected[0, 0])
    z1 = WEIGHT * (ACTIVE * expected[0, 1])
    for point in range(1, 7):
        z0 += WEIGHT * expected[point, 0]
        z1 += WEIGHT * expected[point, 1]
    # The camera's slow error adds to what it sees of the offset.
    u = expected[0, 0] - z0
    w = expected[0, 1] - z1
    s00 = offset_sigma_m * offset_sigma_m + CENTRE_WEIGHT * u * u
    s01 = CENTRE_WEIGHT * u * w
    s11 = slope_sigma * slope_sigma + CENTRE_WEIGHT * w * w
    for k in range(ACTIVE):
        for side in range(2):
            point = 1 + 2 * k + side if k < 3 else 0
            d0 = expected[point, 0] - z0 + (root[k, _CAMERA] if side == 0 else -root[k, _CAMERA])
            d1 = expected[point, 1] - z1
            s00 += WEIGHT * d0 * d0
            s01 += WEIGHT * d0 * d1
            s11 += WEIGHT * d1 * d1
    det = s00 * s11 - s01 * s01
    nu0 = offset_m - z0 - mean[SLOW]
    nu1 = slope - z1
    # One column of the root at a time: cross covariance, gain K = C / S, mean + K ν, P - K C.
    for i in range(ACTIVE):
        c0 = 0.0
        c1 = 0.0
        for k in range(i + 1):
            d0, d1 = _difference(root, expected, k)
            c0 += WEIGHT * root[k, i] * d0
            c1 += WEIGHT * root[k, i] * d1
        gain0 = (c0 * s11 - c1 * s01) / det
        gain1 = (c1 * s00 - c0 * s01) / det
        mean[_AT[i]] += gain0 * nu0 + gain1 * nu1
        for j in range(i + 1):
            e0 = 0.0
            e1 = 0.0
            for k in range(j + 1):
                d0, d1 = _difference(root, expected, k)
                e0 += WEIGHT * root[k, j] * d0
                e1 += WEIGHT * root[k, j] * d1
            P[_AT[i], _AT[j]] -= gain0 * e0 + gain1 * e1
            P[_AT[j], _AT[i]] = P[_AT[i], _AT[j]]
    mean[2] = wrap_angle(mean[2])
    return centre, repairs


@inline
def _difference(root: Floats, expected: Floats, k: int) -> tuple[float, float]:
    """Return what the two sigma points of row k of the root expect to see, less each other."""
    camera = 2.0 * root[k, _CAMERA]
    if k >= 3:
        return camera, 0.0
    return expected[1 + 2 * k, 0] - expected[2 + 2 * k, 0] + camera, expected[1 + 2 * k, 1] - expected[2 + 2 * k, 1]
