"""The smooth wander of fixes, step by step; see `gpsec.sensors.smooth`. Only profiles that have one pay for it."""

from math import sqrt

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.noise import (
    GNSS_OFFSET_EAST,
    GNSS_OFFSET_NORTH,
    GNSS_WANDER_EAST,
    GNSS_WANDER_NORTH,
    normal,
)
from gpsec.sensors.sense_kernels import ENTRY
from gpsec.sensors.smooth import GAIN, HOLD_DECAY, RATE, RATE_DECAY, RATE_KICK, REACH, TOGETHER
from gpsec.sensors.state import SensorState
from gpsec.types.vehicles import Measurements, Vehicles


@kernel
def enter_wander(rows: Ints, step: int, truth: Vehicles, wander: Floats, mind: SensorState) -> None:
    """Draw rate and wander of vehicles that enter from what they are in the long run, in which they go together."""
    for row in rows:
        key, p = truth.key[row], truth.profile[row]
        rest = sqrt(1.0 - wander[p, TOGETHER] * wander[p, TOGETHER])
        for axis in range(2):
            rate = normal(key, GNSS_WANDER_EAST if axis == 0 else GNSS_WANDER_NORTH, ENTRY + step)
            other = normal(key, GNSS_OFFSET_EAST if axis == 0 else GNSS_OFFSET_NORTH, ENTRY + step)
            mind.wander_mps[row, axis] = wander[p, RATE] * rate
            mind.wander_m[row, axis] = wander[p, REACH] * (wander[p, TOGETHER] * rate + rest * other)


@kernel
def wander_fixes(rows: Ints, step: int, truth: Vehicles, wander: Floats, mind: SensorState, out: Measurements) -> None:
    """Let rates and wanders go on by a step, and add them to the fixes of this step."""
    for row in rows:
        key, p = truth.key[row], truth.profile[row]
        for axis in range(2):
            kick = normal(key, GNSS_WANDER_EAST if axis == 0 else GNSS_WANDER_NORTH, step)
            before = mind.wander_mps[row, axis]
            rate = wander[p, RATE_DECAY] * before + wander[p, RATE_KICK] * kick
            mind.wander_mps[row, axis] = rate
            moved = wander[p, GAIN] * 0.5 * (before + rate)
            mind.wander_m[row, axis] = wander[p, HOLD_DECAY] * mind.wander_m[row, axis] + moved
            if out.fix_valid[row]:
                out.fix_m[row, axis] += mind.wander_m[row, axis]
