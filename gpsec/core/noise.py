"""Counter-based random numbers: a draw depends on (key, channel, step) and on nothing else.

The key stands for seed and vehicle, so results change neither with threads and batch size, nor with the order of
vehicles, nor with which other plans and defences run. The mixer is the finaliser of SplitMix64 (Steele, Lea and
Flood, OOPSLA 2014), applied once per word of the counter; normal deviates are Box-Muller's.
"""

from hashlib import blake2b
from math import cos, log, pi, sqrt

import numpy as np

from gpsec.core.arrays import Floats, Keys
from gpsec.core.kernels import allocating_kernel, inline

# One number a channel. A channel is never reused for another purpose: that would correlate the two.
GNSS_WHITE_EAST, GNSS_WHITE_NORTH, GNSS_BIAS_EAST, GNSS_BIAS_NORTH, GNSS_DROPOUT = 1, 2, 3, 4, 5
GNSS_TAPE, CAMERA_TAPE = 7, 49
GNSS_WANDER_EAST, GNSS_WANDER_NORTH, GNSS_OFFSET_EAST, GNSS_OFFSET_NORTH = 8, 9, 14, 15
CAMERA_TAIL, CAMERA_LINE = 50, 51
GNSS_CLOCK, GYRO_CLOCK, ODOMETER_CLOCK, HEADING_CLOCK, CAMERA_CLOCK = 6, 13, 23, 33, 47
GYRO_WHITE, GYRO_BIAS, GYRO_DROPOUT = 10, 11, 12
ODOMETER_WHITE, ODOMETER_SCALE, ODOMETER_DROPOUT = 20, 21, 22
HEADING_WHITE, HEADING_BIAS, HEADING_DROPOUT = 30, 31, 32
CAMERA_C0, CAMERA_C1, CAMERA_C2, CAMERA_C3, CAMERA_BIAS, CAMERA_MOUNT, CAMERA_DROPOUT = 40, 41, 42, 43, 44, 45, 46
CAMERA_MISTAKE = 48
FLEET_EQUIPPED, FLEET_PROFILE = 60, 61
MAP_FIELD, MAP_ROAD = 80, 81
MULTIPATH_PLACE, MULTIPATH_DIRECTION = 82, 83
COMMON_BIAS_EAST, COMMON_BIAS_NORTH = 84, 85
CANYON_EAST, CANYON_NORTH, CANYON_SIZE = 86, 87, 88
TAKEOVER_TIME, INJECTED_ALARM = 90, 91
PLAN_SHARE, PLAN_START, PLAN_DURATION, PLAN_SIDE, PLAN_ATTACK_EAST, PLAN_ATTACK_NORTH = 70, 71, 72, 73, 74, 75

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MUL_1 = np.uint64(0xBF58476D1CE4E5B9)
_MUL_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_SECOND = np.uint64(0xD1B54A32D192ED03)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2**-53


def vehicle_key(seed: int, vehicle_id: str) -> int:
    """Return the 64-bit identity of a vehicle in a run with that seed."""
    digest = blake2b(vehicle_id.encode(), digest_size=8, salt=seed.to_bytes(16, "little", signed=True))
    return int.from_bytes(digest.digest(), "little")


def plain_uniform(key: int, channel: int, step: int) -> float:
    """Return the draw of `uniform`, without machine code: for who draws a few times only."""
    word = _plain_mix(key + int(_GAMMA) * (channel + 1))
    word = _plain_mix(word + int(_GAMMA) * (step + 1))
    return (float(word >> 11) + 0.5) * _TO_UNIT


def plain_normal(key: int, channel: int, step: int) -> float:
    """Return the draw of `normal`, without machine code."""
    word = _plain_mix(_plain_mix(key + int(_GAMMA) * (channel + 1)) + int(_GAMMA) * (step + 1))
    u = (float(word >> 11) + 0.5) * _TO_UNIT
    v = float(_plain_mix(word ^ int(_SECOND)) >> 11) * _TO_UNIT
    return sqrt(-2.0 * log(u)) * cos(2.0 * pi * v)


def _plain_mix(word: int) -> int:
    word %= 1 << 64
    word = (word ^ (word >> 30)) * int(_MUL_1) % (1 << 64)
    word = (word ^ (word >> 27)) * int(_MUL_2) % (1 << 64)
    return word ^ (word >> 31)


@inline
def mix(word: np.uint64) -> np.uint64:
    """Return the finaliser of SplitMix64 of `word`."""
    word = (word ^ (word >> _S30)) * _MUL_1
    word = (word ^ (word >> _S27)) * _MUL_2
    return word ^ (word >> _S31)


@inline
def uniform(key: np.uint64, channel: int, step: int) -> float:
    """Return a draw from the open interval (0, 1)."""
    word = mix(key + _GAMMA * np.uint64(channel + 1))
    word = mix(word + _GAMMA * np.uint64(step + 1))
    return (float(word >> _S11) + 0.5) * _TO_UNIT


@inline
def normal(key: np.uint64, channel: int, step: int) -> float:
    """Return a draw from the standard normal distribution."""
    word = mix(key + _GAMMA * np.uint64(channel + 1))
    word = mix(word + _GAMMA * np.uint64(step + 1))
    u = (float(word >> _S11) + 0.5) * _TO_UNIT
    v = float(mix(word ^ _SECOND) >> _S11) * _TO_UNIT
    return sqrt(-2.0 * log(u)) * cos(2.0 * pi * v)


@allocating_kernel
def uniforms(keys: Keys, channel: int, step: int) -> Floats:
    """Return one uniform draw for each of (N,) keys."""
    draws = np.empty(len(keys))
    for i in range(len(keys)):
        draws[i] = uniform(keys[i], channel, step)
    return draws


@allocating_kernel
def normals(keys: Keys, channel: int, step: int) -> Floats:
    """Return one standard normal draw for each of (N,) keys."""
    draws = np.empty(len(keys))
    for i in range(len(keys)):
        draws[i] = normal(keys[i], channel, step)
    return draws
