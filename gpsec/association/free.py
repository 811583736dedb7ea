"""The free filter: dead reckoning, and the fixes that agree with it. It knows neither camera nor map nor lane.

Its state is the position and the scale error of the odometer. It says whether fixes can be trusted. If that depended on
the lane, a wrong lane that fits a spoofed fix would keep itself.
"""

from math import cos, exp, sin
from typing import NamedTuple

from gpsec.association.state import Association
from gpsec.core.arrays import Floats
from gpsec.core.geo import dead_reckon
from gpsec.core.kernels import inline
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise

# The free filter accepts a fix whose normalised innovation squared is below this: of honest ones, 3 in 10,000 are not.
GATE = 16.0
# Learning the white noise of fixes: time constant, where squares are cut, and the mean of such a cut square of a
# standard normal number.
LEARN_S, CUT, CUT_MEAN = 20.0, 6.0, 0.9384
# Bounds of what is learnt, as logarithms of a variance; the upper one is ten times the data sheet's deviation.
LEAST, MOST = -1.0, 4.6
# The learnt scale error stays within so many standard deviations of the data sheet: an attacker's slow drift along the
# lane looks like one.
MOST_SCALE = 1.5


class Motion(NamedTuple):
    """How a vehicle moved in a step by its own sensors.

    Attributes:
        dx, dy: way per metre of the odometer, east and north.
        c, s: direction in the middle of the step.
        way_m: by the odometer, with its scale error.
        speed_mps: likewise.
    """

    dx: float
    dy: float
    c: float
    s: float
    way_m: float
    speed_mps: float


@inline
def motion_of(speed_mps: float, turn_rad: float, heading_rad: float, step_s: float) -> Motion:
    """Return the motion of a step at whose end the heading is `heading_rad`, and in which it turned by `turn_rad`."""
    dx, dy = dead_reckon(0.0, 0.0, heading_rad - turn_rad, 1.0, turn_rad)
    middle = heading_rad - 0.5 * turn_rad
    return Motion(dx, dy, cos(middle), sin(middle), speed_mps * step_s, speed_mps)


@inline
def start_free(state: Association, row: int, noise: FilterNoise[Floats], profile: int, x_m: float, y_m: float) -> None:
    """Start at a fix, with the scale error unknown."""
    state.free_m[row, 0], state.free_m[row, 1] = x_m, y_m
    state.free_scale[row] = 0.0
    P = state.free_covariance[row]
    P[0] = noise.gnss_white_m[profile] ** 2 + noise.gnss_bias_m[profile] ** 2
    P[1], P[2], P[3], P[4] = 0.0, P[0], 0.0, 0.0
    P[5] = noise.odometer_scale[profile] ** 2
    state.accepted[row] = 0


@inline
def predict(
    state: Association, row: int, noise: FilterNoise[Floats], profile: int, motion: Motion, step_s: float
) -> None:
    """Move by odometer and heading: P' = F P Fᵀ + Q, with d(position)/d(scale) = -way."""
    P = state.free_covariance[row]
    way = motion.way_m / (1.0 + state.free_scale[row])
    dx, dy = way * motion.dx, way * motion.dy
    state.free_m[row, 0] += dx
    state.free_m[row, 1] += dy
    xs, ys, ss = P[3], P[4], P[5]
    P[0] += dx * (dx * ss - 2.0 * xs)
    P[1] += dx * dy * ss - dx * ys - dy * xs
    P[2] += dy * (dy * ss - 2.0 * ys)
    P[3] -= dx * ss
    P[4] -= dy * ss
    white = noise.odometer_white_mps[profile] * step_s
    along = white * white
    sideways = noise.heading_rad[profile] * motion.speed_mps
    across = sideways * sideways * step_s * LASTING_ERROR_S
    # The slow error of fixes wanders, and the free position with it.
    bias = noise.gnss_bias_m[profile]
    wander = 2.0 * bias * bias * step_s / noise.gnss_bias_tau_s[profile]
    P[0] += along * motion.c * motion.c + across * motion.s * motion.s + wander
    P[1] += (along - across) * motion.c * motion.s
    P[2] += along * motion.s * motion.s + across * motion.c * motion.c + wander


@inline
def white_variance(state: Association, row: int, noise: FilterNoise[Floats], profile: int) -> float:
    """Return the variance of the white noise of a fix, as it was learnt, per axis."""
    white = noise.gnss_white_m[profile]
    return float(white * white * exp(state.noise[row]))


@inline
def take_fix(state: Association, row: int, noise: FilterNoise[Floats], profile: int, x_m: float, y_m: float) -> None:
    """Test a fix, learn the white noise of fixes, and correct by it where it is accepted."""
    P = state.free_covariance[row]
    nx, ny = x_m - state.free_m[row, 0], y_m - state.free_m[row, 1]
    variance = white_variance(state, row, noise, profile)
    if state.accepted[row] != 0:
        # Between two fixes the white noise of both is what differs from the way, whatever bias both have.
        ux, uy = nx - state.left_over_m[row, 0], ny - state.left_over_m[row, 1]
        cut = min(0.5 * ux * ux / variance, CUT) + min(0.5 * uy * uy / variance, CUT)
        learnt = state.noise[row] + 0.5 * noise.gnss_period_s[profile] / LEARN_S * (cut - 2.0 * CUT_MEAN)
        state.noise[row] = min(max(learnt, LEAST), MOST)
    a, b, c = P[0] + variance, P[1], P[2] + variance
    if c * nx * nx - 2.0 * b * nx * ny + a * ny * ny > GATE * (a * c - b * b):
        state.accepted[row] = -1
        state.left_over_m[row, 0], state.left_over_m[row, 1] = nx, ny
        return
    state.accepted[row] = max(state.accepted[row], 0) + 1
    # One axis after the other: their white errors are independent.
    for axis in range(2):
        if axis == 0:
            hx, hy, hs, seen = P[0], P[1], P[3], x_m
        else:
            hx, hy, hs, seen = P[1], P[2], P[4], y_m
        S = (hx if axis == 0 else hy) + variance
        nu = seen - state.free_m[row, axis]
        kx, ky, ks = hx / S, hy / S, hs / S
        state.free_m[row, 0] += kx * nu
        state.free_m[row, 1] += ky * nu
        state.free_scale[row] += ks * nu
        P[0] -= kx * hx
        P[1] -= kx * hy
        P[2] -= ky * hy
        P[3] -= kx * hs
        P[4] -= ky * hs
        P[5] -= ks * hs
    most = MOST_SCALE * noise.odometer_scale[profile]
    if abs(state.free_scale[row]) > most:
        # The true one is somewhere beyond.
        state.free_scale[row] = most if state.free_scale[row] > 0.0 else -most
        P[5] = max(P[5], noise.odometer_scale[profile] ** 2)
    state.left_over_m[row, 0], state.left_over_m[row, 1] = x_m - state.free_m[row, 0], y_m - state.free_m[row, 1]
