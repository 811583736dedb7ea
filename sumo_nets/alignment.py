"""Road alignments: straight lines, clothoids and circular arcs that join with equal tangents.

An alignment is a tuple of segments with linear curvature. It is laid out either through points of intersection
(`through`: the classical road design, where the straight lines are given and each corner is rounded by a
clothoid-arc-clothoid), or step by step from a start pose (`drive`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

Pose = tuple[float, float, float]
"""x_m, y_m, heading_rad; the heading is counter-clockwise from east."""

SPIRAL_SHARE = 0.5
"""Share of a curve's deflection that its two clothoids take, unless their length is limited."""

SPIRAL_MAX_M = 150.0
SPIRAL_MIN_M = 2.0
"""A shorter clothoid is left out: netconvert cannot discretise it without touching points."""

SHORTEST_LINE_M = 0.05


@dataclass(frozen=True)
class Segment:
    """One piece of an alignment, with a curvature that changes linearly from `k0` to `k1` (1/m, left positive)."""

    x: float
    y: float
    heading: float
    length: float
    k0: float = 0.0
    k1: float = 0.0

    def pose_at(self, s: float) -> Pose:
        """Pose at distance `s` (m) from the segment's start."""
        dx, dy, turned = _local_end(s, self.k0, self.k0 + (self.k1 - self.k0) * s / self.length)
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return self.x + cos * dx - sin * dy, self.y + sin * dx + cos * dy, self.heading + turned

    def cut(self, start: float, end: float) -> Segment:
        """Return the part between `start` and `end` (m from the segment's start)."""
        x, y, heading = self.pose_at(start)
        slope = (self.k1 - self.k0) / self.length
        return Segment(x, y, heading, end - start, self.k0 + slope * start, self.k0 + slope * end)


@dataclass(frozen=True)
class Alignment:
    """A chain of segments."""

    segments: tuple[Segment, ...]

    @property
    def length(self) -> float:
        """Length in m."""
        return sum(segment.length for segment in self.segments)

    @property
    def start(self) -> Pose:
        """Pose at the beginning."""
        return self.segments[0].pose_at(0.0)

    @property
    def end(self) -> Pose:
        """Pose at the end."""
        return self.segments[-1].pose_at(self.segments[-1].length)

    def slice(self, start: float, end: float) -> Alignment:
        """Return the part between two stations (m); slivers under 5 cm are left out."""
        pieces = []
        s = 0.0
        for segment in self.segments:
            lo, hi = max(start - s, 0.0), min(end - s, segment.length)
            if hi - lo > SHORTEST_LINE_M:
                pieces.append(segment.cut(lo, hi))
            s += segment.length
        return Alignment(tuple(pieces))

    def pose_at(self, s: float) -> Pose:
        """Pose at station `s` (m)."""
        for segment in self.segments:
            if s <= segment.length:
                return segment.pose_at(s)
            s -= segment.length
        return self.end

    def reversed(self) -> Alignment:
        """Return the same line, driven the other way."""
        segments = []
        for segment in reversed(self.segments):
            x, y, heading = segment.pose_at(segment.length)
            segments.append(Segment(x, y, heading + math.pi, segment.length, -segment.k1, -segment.k0))
        return Alignment(tuple(segments))

    def __add__(self, other: Alignment) -> Alignment:
        """Return the alignment followed by another one that starts where this one ends."""
        return Alignment(self.segments + other.segments)


def through(points: Sequence[Sequence[float]]) -> Alignment:
    """Lay an alignment through points of intersection.

    The first and last point are (x, y), the ones between are (x, y, radius) or (x, y, radius, clothoid length).
    Raises ValueError where two curves overlap.
    """
    segments: list[Segment] = []
    x, y = points[0][0], points[0][1]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        heading = math.atan2(corner[1] - before[1], corner[0] - before[0])
        deflection = _wrap(math.atan2(after[1] - corner[1], after[0] - corner[0]) - heading)
        if abs(deflection) < 1e-4:
            continue
        radius = corner[2]
        spiral = _spiral_length(radius, abs(deflection), corner[3] if len(corner) > 3 else None)
        tangent = _tangent_length(radius, abs(deflection), spiral)
        line = (corner[0] - x) * math.cos(heading) + (corner[1] - y) * math.sin(heading) - tangent
        if line < -1e-6:
            raise ValueError(f"the curve at ({corner[0]}, {corner[1]}) begins {-line:.1f} m before the last one ends")
        pose: Pose = (x, y, heading)
        pose = _append(segments, pose, line, 0.0, 0.0)
        pose = _append_curve(segments, pose, radius, deflection, spiral)
        x, y = pose[0], pose[1]
    heading = math.atan2(points[-1][1] - points[-2][1], points[-1][0] - points[-2][0])
    line = (points[-1][0] - x) * math.cos(heading) + (points[-1][1] - y) * math.sin(heading)
    if line < -1e-6:
        raise ValueError(f"the last curve ends {-line:.1f} m behind ({points[-1][0]}, {points[-1][1]})")
    _append(segments, (x, y, heading), line, 0.0, 0.0)
    return Alignment(tuple(segments))


def drive(start: Pose, steps: Sequence[float | tuple[float, float]]) -> Alignment:
    """Lay an alignment step by step.

    A number is a straight (m), a pair is a turn (degrees, left positive; radius in m).
    """
    segments: list[Segment] = []
    pose = start
    for step in steps:
        if isinstance(step, tuple):
            angle, radius = math.radians(step[0]), step[1]
            pose = _append_curve(segments, pose, radius, angle, _spiral_length(radius, abs(angle), None))
        else:
            pose = _append(segments, pose, step, 0.0, 0.0)
    return Alignment(tuple(segments))


def fillet(start: Pose, end: Pose) -> Alignment | None:
    """Join two poses by line, curve, line; None where one curve cannot do it."""
    x0, y0, h0 = start
    x1, y1, h1 = end
    deflection = _wrap(h1 - h0)
    along = (x1 - x0) * math.cos(h0) + (y1 - y0) * math.sin(h0)
    aside = (y1 - y0) * math.cos(h0) - (x1 - x0) * math.sin(h0)
    if abs(deflection) < 1e-3:
        return Alignment((Segment(x0, y0, h0, along),)) if abs(aside) < 2e-3 and along > 0 else None
    after = aside / math.sin(deflection)
    before = along - after * math.cos(deflection)
    tangent = min(before, after)
    if tangent < 1.0 or abs(deflection) > math.radians(160):
        return None
    unit = _tangent_length(1.0, abs(deflection), SPIRAL_SHARE * abs(deflection))
    radius = tangent / unit
    segments: list[Segment] = []
    pose = _append(segments, start, before - tangent, 0.0, 0.0)
    pose = _append_curve(segments, pose, radius, deflection, SPIRAL_SHARE * abs(deflection) * radius)
    _append(segments, pose, after - tangent, 0.0, 0.0)
    return Alignment(tuple(segments))


def _append_curve(segments: list[Segment], pose: Pose, radius: float, deflection: float, spiral: float) -> Pose:
    """Append clothoid, arc, clothoid."""
    curvature = math.copysign(1.0 / radius, deflection)
    arc = abs(deflection) * radius - spiral
    pose = _append(segments, pose, spiral, 0.0, curvature)
    pose = _append(segments, pose, arc, curvature, curvature)
    return _append(segments, pose, spiral, curvature, 0.0)


def _append(segments: list[Segment], pose: Pose, length: float, k0: float, k1: float) -> Pose:
    """Append a segment and return the pose at its end; a sliver is left out."""
    if length < SHORTEST_LINE_M:
        return pose
    segment = Segment(*pose, length, k0, k1)
    segments.append(segment)
    return segment.pose_at(length)


def _spiral_length(radius: float, deflection: float, wanted: float | None) -> float:
    """Length of a curve's clothoids: as wanted, at most `SPIRAL_SHARE` of the deflection, none if very short."""
    longest = SPIRAL_SHARE * deflection * radius
    length = min(longest, SPIRAL_MAX_M if wanted is None else wanted)
    return length if length >= SPIRAL_MIN_M else 0.0


def _tangent_length(radius: float, deflection: float, spiral: float) -> float:
    """Distance from the corner to the beginning of its clothoid-arc-clothoid curve."""
    x, y, theta = _local_end(spiral, 0.0, 1.0 / radius) if spiral > 0 else (0.0, 0.0, 0.0)
    shift = y - radius * (1.0 - math.cos(theta))
    return (radius + shift) * math.tan(deflection / 2.0) + x - radius * math.sin(theta)


def _local_end(length: float, k0: float, k1: float) -> tuple[float, float, float]:
    """End of a segment in its own start frame: Gauss-Legendre quadrature over pieces of at most 0.2 rad."""
    turned = 0.5 * (k0 + k1) * length
    pieces = max(1, math.ceil(max(abs(k0), abs(k1)) * length / 0.2))
    x = y = 0.0
    step = length / pieces
    slope = (k1 - k0) / length if length > 0 else 0.0
    for piece in range(pieces):
        for node, weight in _GAUSS:
            s = (piece + 0.5 + 0.5 * node) * step
            angle = k0 * s + 0.5 * slope * s * s
            x += 0.5 * step * weight * math.cos(angle)
            y += 0.5 * step * weight * math.sin(angle)
    return x, y, turned


def _wrap(angle: float) -> float:
    """Wrap to (-pi, pi]."""
    return math.atan2(math.sin(angle), math.cos(angle))


_GAUSS = (
    (0.0, 128 / 225),
    (-0.5384693101056831, 0.47862867049936647),
    (0.5384693101056831, 0.47862867049936647),
    (-0.9061798459386640, 0.23692688505618908),
    (0.9061798459386640, 0.23692688505618908),
)
"""Five-point Gauss-Legendre nodes and weights on [-1, 1]."""
