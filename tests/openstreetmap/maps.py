"""Small OpenStreetMap extracts, written out."""

from math import cos, pi, radians, sin
from pathlib import Path

LAT, LON = 52.26, 10.52
_DEGREE_M = 111_200.0

Node = tuple[float, float]
Tags = dict[str, str]
Way = tuple[list[int], Tags]


def document(
    nodes: dict[int, Node], ways: list[Way], signals: tuple[int, ...] = (), lat: float = LAT, lon: float = LON
) -> str:
    """Return an extract; nodes are metres east and north of a place."""
    east_m = _DEGREE_M * cos(radians(lat))
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<osm version="0.6" generator="hand">']
    for number, (x, y) in nodes.items():
        tag = '<tag k="highway" v="traffic_signals"/>' if number in signals else ""
        lines.append(f'<node id="{number}" lat="{lat + y / _DEGREE_M:.8f}" lon="{lon + x / east_m:.8f}">{tag}</node>')
    for number, (along, tags) in enumerate(ways, 1):
        inside = [f'<nd ref="{node}"/>' for node in along] + [f'<tag k="{k}" v="{v}"/>' for k, v in tags.items()]
        lines.append(f'<way id="{number}">{"".join(inside)}</way>')
    return "\n".join([*lines, "</osm>", ""])


def ring(first: int, count: int, radius_m: float, clockwise: bool) -> dict[int, Node]:
    """Return the nodes of a roundabout about the origin, numbered in the order in which it is driven."""
    turn = (-1 if clockwise else 1) * 2.0 * pi / count
    return {first + k: (radius_m * cos(k * turn), radius_m * sin(k * turn)) for k in range(count)}


def write(folder: Path, text: str, name: str = "town.osm") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


CROSSING_NODES = {
    1: (-300.0, 0.0),
    2: (0.0, 0.0),
    3: (300.0, 0.0),
    4: (0.0, -300.0),
    5: (0.0, 300.0),
    6: (100.0, 300.0),
    7: (40.0, 40.0),
}
CROSSING_WAYS: list[Way] = [
    ([1, 2, 3], {"highway": "primary", "lanes": "4", "maxspeed": "50", "name": "Main Street"}),
    ([4, 2, 5], {"highway": "secondary", "maxspeed": "50"}),
    ([5, 6], {"highway": "residential"}),
    ([2, 7], {"highway": "footway"}),
]
CROSSING = document(CROSSING_NODES, CROSSING_WAYS, signals=(2,))
