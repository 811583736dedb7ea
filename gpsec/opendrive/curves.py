"""The five curves of an OpenDRIVE reference line, as points and directions in the frame of their beginning.

A curve gives u (ahead), v (left) and the direction at any distance along it (ASAM OpenDRIVE 1.8, chapter 9). Distances
are arc lengths also where the file gives a polynomial of another parameter.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.special import fresnel

from gpsec.core.arrays import Floats

# A curve that turns by less than this more or less than a circle is one.
_SAME_TURN_RAD = 1e-9
_TABLE_STEP_M = 0.1
_LEAST_STEPS = 16
# Three nodes and weights of Gauss and Legendre on [0, 1].
_NODES = 0.5 + 0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])
_WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0


class Course(NamedTuple):
    """Points and directions of a curve: (n,) arrays.

    Attributes:
        u_m, v_m: ahead of the beginning, and to its left.
        turn_rad: direction, against that of the beginning.
    """

    u_m: Floats
    v_m: Floats
    turn_rad: Floats


class ReferenceLineCurve(Protocol):
    """A curve of a given length."""

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances from the beginning of a curve that is `length_m` long."""


@dataclass(frozen=True)
class Line:
    """A straight line."""

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances."""
        return Course(distance_m, np.zeros_like(distance_m), np.zeros_like(distance_m))


@dataclass(frozen=True)
class Arc:
    """A circular arc of constant curvature (1/m, left positive)."""

    curvature_per_m: float

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances: chords of length s·sinc(κs/2), which turn by κs/2."""
        turn = self.curvature_per_m * distance_m
        chord = distance_m * np.sinc(turn / (2.0 * np.pi))  # numpy's sinc has π in it
        return Course(chord * np.cos(0.5 * turn), chord * np.sin(0.5 * turn), turn)


@dataclass(frozen=True)
class Spiral:
    """A clothoid: the curvature changes in proportion to the distance."""

    start_per_m: float
    end_per_m: float

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances, from Fresnel integrals.

        The direction is κs + κ's²/2 = κ'/2·(s + κ/κ')² − κ²/2κ', so the integral of its cosine and sine is a piece of
        the clothoid that begins straight, turned by −κ²/2κ'.
        """
        slope = (self.end_per_m - self.start_per_m) / length_m
        if abs(slope) * length_m * length_m < _SAME_TURN_RAD:
            return Arc(0.5 * (self.start_per_m + self.end_per_m)).course(distance_m, length_m)
        turn = self.start_per_m * distance_m + 0.5 * slope * distance_m**2
        scale, side = np.sqrt(np.pi / abs(slope)), np.sign(slope)
        before = self.start_per_m / slope
        sine, cosine = fresnel((distance_m + before) / scale)
        sine0, cosine0 = fresnel(before / scale)
        ahead, left = scale * (cosine - cosine0), side * scale * (sine - sine0)
        back = 0.5 * self.start_per_m * before
        return Course(
            np.cos(back) * ahead + np.sin(back) * left,
            np.cos(back) * left - np.sin(back) * ahead,
            turn,
        )


@dataclass(frozen=True)
class Poly3:
    """v is a cubic polynomial of u, by its coefficients."""

    coefficients: Floats

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances: u is where the arc length is reached."""
        slope = _derivative(self.coefficients)
        u, _ = _at_distance(lambda u: np.hypot(1.0, _value(slope, u)), length_m, length_m, distance_m)
        return Course(u, _value(self.coefficients, u), np.arctan(_value(slope, u)))


@dataclass(frozen=True)
class ParamPoly3:
    """u and v are cubic polynomials of a parameter that runs from 0 to `end`.

    OpenDRIVE calls the parameter arc length or normalised; few files fulfil that to the millimetre. Here a distance is
    the share of the arc length that it is of `length_m`, so that the curve ends where the file ends it.
    """

    u: Floats
    v: Floats
    end: float

    def course(self, distance_m: Floats, length_m: float) -> Course:
        """Return the course at (n,) distances."""
        du, dv = _derivative(self.u), _derivative(self.v)

        def speed(p: Floats) -> Floats:
            return np.hypot(_value(du, p), _value(dv, p))

        total = _at_distance(speed, self.end, length_m, np.zeros(0))[1]
        p, _ = _at_distance(speed, self.end, length_m, distance_m * (total / length_m))
        return Course(_value(self.u, p), _value(self.v, p), np.arctan2(_value(dv, p), _value(du, p)))


def _at_distance(
    speed: Callable[[Floats], Floats], end: float, length_m: float, distance_m: Floats
) -> tuple[Floats, float]:
    """Return the parameters at (n,) distances along a curve, and the length of all of it.

    Arc lengths come from Gauss-Legendre quadrature of `speed` over `_TABLE_STEP_M` of the curve at a time, parameters
    between them by linear interpolation.
    """
    steps = max(_LEAST_STEPS, int(np.ceil(length_m / _TABLE_STEP_M)))
    grid = np.linspace(0.0, end, steps + 1)
    step = end / steps
    pieces = (speed(grid[:-1, None] + step * _NODES) * _WEIGHTS).sum(axis=1) * step
    reached = np.concatenate([[0.0], np.cumsum(pieces)])
    return np.interp(distance_m, reached, grid), float(reached[-1])


def _value(coefficients: Floats, p: Floats) -> Floats:
    a, b, c, d = np.pad(coefficients, (0, 4 - len(coefficients)))
    value: Floats = a + p * (b + p * (c + p * d))
    return value


def _derivative(coefficients: Floats) -> Floats:
    slope: Floats = coefficients[1:] * np.arange(1.0, len(coefficients))
    return slope
