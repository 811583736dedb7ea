"""Rectangles on the road, and when two of them touch: separating axes, at rest and in motion."""

from math import inf
from typing import NamedTuple

from gpsec.core.arrays import Floats
from gpsec.core.kernels import inline


class Bodies(NamedTuple):
    """B vehicles as rectangles that move straight on.

    Attributes:
        x_m, y_m: (B,) centres in the net's frame.
        ux, uy: (B,) unit vectors along the bodies.
        half_length_m, half_width_m: (B,) of the bodies.
        vx_mps, vy_mps: (B,) velocities.
    """

    x_m: Floats
    y_m: Floats
    ux: Floats
    uy: Floats
    half_length_m: Floats
    half_width_m: Floats
    vx_mps: Floats
    vy_mps: Floats


@inline
def _reach(bodies: Bodies, i: int, ax: float, ay: float) -> float:
    """Return how far a rectangle reaches from its centre along an axis."""
    along = bodies.ux[i] * ax + bodies.uy[i] * ay
    across = bodies.ux[i] * ay - bodies.uy[i] * ax
    return float(bodies.half_length_m[i] * abs(along) + bodies.half_width_m[i] * abs(across))


@inline
def meeting(bodies: Bodies, i: int, j: int) -> tuple[float, float]:
    """Return the gap of two rectangles along the axis that parts them most, and the seconds until they touch.

    A gap below 0 means that they overlap; it is at most their distance. The seconds are 0 where they overlap, and
    infinite where they never touch. Both bodies go straight on as they are. Two rectangles touch just when they overlap
    along the axes of both (Gottschalk, Lin and Manocha, SIGGRAPH 1996); with constant velocities and directions each
    axis gives an interval of time, and the contact is where all four intervals meet.
    """
    dx, dy = bodies.x_m[j] - bodies.x_m[i], bodies.y_m[j] - bodies.y_m[i]
    wx, wy = bodies.vx_mps[j] - bodies.vx_mps[i], bodies.vy_mps[j] - bodies.vy_mps[i]
    gap, enter, leave = -inf, 0.0, inf
    for k in range(4):
        of = i if k < 2 else j
        ax, ay = bodies.ux[of], bodies.uy[of]
        if k % 2:
            ax, ay = -ay, ax
        reach = _reach(bodies, i, ax, ay) + _reach(bodies, j, ax, ay)
        apart, closing = dx * ax + dy * ay, wx * ax + wy * ay
        gap = max(gap, abs(apart) - reach)
        if abs(closing) > 1e-9:
            at = -apart / closing
            half = reach / abs(closing)
            enter, leave = max(enter, at - half), min(leave, at + half)
        elif abs(apart) >= reach:
            leave = -inf
    if gap < 0.0:
        return gap, 0.0
    return gap, (enter if enter < leave else inf)
