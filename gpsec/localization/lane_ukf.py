"""The UKF of `ukf5`: the camera's lane offset and lane direction correct all that is left when GNSS is isolated.

State: east, north, yaw, scale error of the odometer, bias of the gyro, and two errors of the camera's offset: the slow
one, and that of its mounting. What is seen is linear in the last four, so that only the first three have sigma points,
2N + 1 = 7 of them, √3 standard deviations away; the others follow by their covariances with these, exactly. Weights are
Merwe's with α = 1, β = 2, κ = 0: none is negative.
"""

from math import cos, sqrt, tan

from gpsec.core.arrays import Floats
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline
from gpsec.filters.learning import GYRO_ERROR, MOUNTING, SCALE, SLOW, lead
from gpsec.filters.noise import FilterNoise
from gpsec.hdmap.around import gather_around, nearest_of
from gpsec.hdmap.arrays import Pose
from gpsec.hdmap.matching import view_on
from gpsec.hdmap.search import MIN_COS, TRACKED, match
from gpsec.localization.sparse_map import map_variances
from gpsec.localization.world import LaneSight, Room, World

ACTIVE, POINTED = 7, 3
# Where the active states are in the filter state: the POINTED that sigma points are of come first.
_AT = (0, 1, 2, SCALE, GYRO_ERROR, SLOW, MOUNTING)
_CAMERA = 5
_CAMERA_MOUNT = 6
# n + λ, weight of each point but the mean, and weight of the mean in covariances (in means it is 0).
_SPREAD, _WEIGHT, _CENTRE_WEIGHT = 3.0, 1.0 / 6.0, 2.0


@inline
def camera_noise(noise: FilterNoise[Floats], profile: int, stated_m: float) -> tuple[float, float]:
    """Return σ of the white parts of C0 and of C1, from the σ that the camera states for C0.

    What is stated includes the slow errors. A shorter view r of the lane makes the white part of C0 grow with r^(-1/2),
    that of C1 with r^(-3/2).
    """
    slow = noise.camera_bias_m[profile] ** 2 + noise.camera_mount_m[profile] ** 2
    full = noise.camera_white_m[profile]
    white = sqrt(max(stated_m * stated_m - slow, full * full))
    ratio = white / full if full > 0.0 else 1.0
    return white, noise.camera_slope[profile] * ratio * ratio * ratio


@inline
def _root(root: Floats, P: Floats) -> int:
    """Set the upper Cholesky factor of (n + λ) P; returns repairs made."""
    repairs = 0
    for k in range(ACTIVE):
        for j in range(k, ACTIVE):
            total = _SPREAD * P[_AT[k], _AT[j]]
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
                    P[_AT[k], _AT[k]] -= total / _SPREAD
                    repairs += 1
    return repairs


@inline
def correct_by_lane(
    mean: Floats, covariance: Floats, hint: int, room: Room, world: World, profile: int, sight: LaneSight
) -> tuple[int, int]:
    """Correct with the camera's lane offset (-C0) and the slope of the lane in the vehicle's frame (C1).

    Returns the segment of the mean (-1 where a sigma point had no match; nothing is corrected then) and repairs made.
    """
    lanes, lookup, mode = world.hd_map.lanes, world.hd_map.lookup, world.hd_map.mode
    layer = world.hd_map.layer[profile]
    offset_sigma_m, slope_sigma = camera_noise(world.noise, profile, sight.sigma_m)
    P = covariance
    root = room.root
    expected = room.expected
    repairs = _root(root, P)
    segment = hint
    count = -1
    heading = mean[2] + lead(world.noise, profile, sight.yaw_rate_rps - mean[GYRO_ERROR])
    if mode == TRACKED:
        reach = max(sqrt(root[0, 0] * root[0, 0] + root[0, 1] * root[0, 1]), root[1, 1])
        pose = Pose(layer, sight.lane, mean[0], mean[1], heading)
        count, segment = gather_around(lanes, lookup, pose, hint, reach, room.near)
    centre = -1
    for point in range(7):
        x = mean[0]
        y = mean[1]
        yaw = heading
        if point > 0:
            k = (point - 1) // 2
            sign = 1.0 if point % 2 == 1 else -1.0
            x += sign * root[k, 0] if k == 0 else 0.0
            y += sign * root[k, 1] if k < 2 else 0.0
            yaw += sign * root[k, 2]
        if count > 0:
            segment = nearest_of(lanes, room.near, count, x, y)
        else:
            segment = match(lanes, lookup, mode, Pose(layer, sight.lane, x, y, yaw), segment)
        if segment < 0:
            return -1, repairs
        offset, turn = view_on(lanes, segment, x, y, yaw, mode == TRACKED)
        if abs(cos(turn)) < MIN_COS:
            return -1, repairs
        expected[point, 0] = offset
        expected[point, 1] = tan(turn)
        if point == 0:
            centre = segment
    z0 = 0.0
    z1 = 0.0
    for point in range(1, 7):
        z0 += _WEIGHT * expected[point, 0]
        z1 += _WEIGHT * expected[point, 1]
    # The camera's errors add to what it sees of the offset.
    u = expected[0, 0] - z0
    w = expected[0, 1] - z1
    map_offset, map_direction = map_variances(world, centre, profile, sight.speed_mps)
    s00 = offset_sigma_m * offset_sigma_m + map_offset + _CENTRE_WEIGHT * u * u
    # What is observed is -C0, so that its white part goes with that of C1 the other way round.
    s01 = _CENTRE_WEIGHT * u * w - world.noise.camera_slope_correlation[profile] * offset_sigma_m * slope_sigma
    s11 = slope_sigma * slope_sigma + map_direction + _CENTRE_WEIGHT * w * w
    for k in range(ACTIVE):
        camera = _camera(root, k)
        for side in range(2):
            d0 = camera if side == 0 else -camera
            d1 = 0.0
            if k < POINTED:
                d0 += expected[1 + 2 * k + side, 0] - z0
                d1 += expected[1 + 2 * k + side, 1] - z1
            s00 += _WEIGHT * d0 * d0
            s01 += _WEIGHT * d0 * d1
            s11 += _WEIGHT * d1 * d1
    det = s00 * s11 - s01 * s01
    nu0 = sight.offset_m - z0 - mean[SLOW] - mean[MOUNTING]
    nu1 = sight.slope - z1
    # One column of the root at a time: cross covariance, gain K = C / S, mean + K ν, P - K C.
    for i in range(ACTIVE):
        c0 = 0.0
        c1 = 0.0
        for k in range(i + 1):
            d0, d1 = _difference(root, expected, k)
            c0 += _WEIGHT * root[k, i] * d0
            c1 += _WEIGHT * root[k, i] * d1
        gain0 = (c0 * s11 - c1 * s01) / det
        gain1 = (c1 * s00 - c0 * s01) / det
        mean[_AT[i]] += gain0 * nu0 + gain1 * nu1
        for j in range(i + 1):
            e0 = 0.0
            e1 = 0.0
            for k in range(j + 1):
                d0, d1 = _difference(root, expected, k)
                e0 += _WEIGHT * root[k, j] * d0
                e1 += _WEIGHT * root[k, j] * d1
            P[_AT[i], _AT[j]] -= gain0 * e0 + gain1 * e1
            P[_AT[j], _AT[i]] = P[_AT[i], _AT[j]]
    mean[2] = wrap_angle(mean[2])
    return centre, repairs


@inline
def _camera(root: Floats, k: int) -> float:
    """Return by how much row k of the root displaces the offset that is seen; below its diagonal a root is not set."""
    return float(root[k, _CAMERA_MOUNT] + (root[k, _CAMERA] if k <= _CAMERA else 0.0))


@inline
def _difference(root: Floats, expected: Floats, k: int) -> tuple[float, float]:
    """Return by how much what is seen changes from one to the other side of the mean, along row k of the root."""
    camera = 2.0 * _camera(root, k)
    if k >= POINTED:
        return camera, 0.0
    return expected[1 + 2 * k, 0] - expected[2 + 2 * k, 0] + camera, expected[1 + 2 * k, 1] - expected[2 + 2 * k, 1]
