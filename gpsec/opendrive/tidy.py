"""Mends internal lanes of netconvert's that have no direction, or one that rounding decides."""

import itertools
import math
import re
from xml.etree import ElementTree

SHORTEST_LANE_M = 0.1
"""The length that SUMO gives a lane at least."""

LANE_WITHOUT_EXTENT_M = 0.05

CLOSEST_POINTS_M = 0.09
"""Less than the shortest lane, so that it keeps its two points."""


def give_extent(text: str) -> str:
    """Draw internal lanes that netconvert leaves without extent, in a net's text.

    Where a road goes on in its next lane section, the lane between the two is a point (or two points less than a
    millimetre apart, in any direction), with a length of 0.1 m. It gets that length, in the direction of the lanes
    that it joins, so that every lane of the net has a heading.
    """
    root = ElementTree.fromstring(text.encode("utf-8"))
    shapes = {lane.get("id", ""): _points(lane.get("shape", "")) for lane in root.iter("lane")}
    drawn: dict[str, str] = {}
    for connection in root.iter("connection"):
        via = connection.get("via")
        if via is None or _length(shapes[via]) > LANE_WITHOUT_EXTENT_M:
            continue
        before = shapes[f"{connection.get('from')}_{connection.get('fromLane')}"]
        after = shapes[f"{connection.get('to')}_{connection.get('toLane')}"]
        x, y = after[0]
        dx, dy = after[1][0] - before[-2][0], after[1][1] - before[-2][1]
        if not (dx or dy):  # a turn back to where one came from
            dx, dy = after[1][0] - x, after[1][1] - y
        half = 0.5 * SHORTEST_LANE_M / (math.hypot(dx, dy) or 1.0)
        drawn[via] = f"{x - dx * half:.4f},{y - dy * half:.4f} {x + dx * half:.4f},{y + dy * half:.4f}"

    def redrawn(match: re.Match[str]) -> str:
        shape = drawn.get(match[2])
        return match[0] if shape is None else f'{match[1]}{match[2]}{match[3]}{shape}"'

    return re.sub(r'(<lane id=")([^"]*)("[^>]*shape=")[^"]*"', redrawn, text)


def thin_out(text: str) -> str:
    """Drop points of internal lanes that lie so close together that rounding decides where they point."""

    def thinned(match: re.Match[str]) -> str:
        corners = match[2].split()
        points = _points(match[2])
        kept = [0]
        for index in range(1, len(points)):
            if math.dist(points[kept[-1]], points[index]) >= CLOSEST_POINTS_M:
                kept.append(index)
        last = len(points) - 1
        if kept[-1] != last:
            kept = [*(kept[:-1] if len(kept) > 1 else kept), last]
        return f'{match[1]}{" ".join(corners[index] for index in kept)}"'

    return re.sub(r'(<lane id=":[^>]*shape=")([^"]*)"', thinned, text)


def _points(shape: str) -> list[tuple[float, float]]:
    """Return the points of a lane's shape (m)."""
    points = [point.split(",") for point in shape.split()]
    return [(float(point[0]), float(point[1])) for point in points]


def _length(points: list[tuple[float, float]]) -> float:
    """Length (m) along points."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))
