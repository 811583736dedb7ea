"""Tiny nets as plain XML, and an independent look at them."""

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import shapely

from gpsec.hdmap.arrays import MapArrays
from gpsec.hdmap.map import HDMap
from gpsec.hdmap.matching import MatchedOffsets, offsets

TWO_WAY = (
    'id="a" x="0" y="0"\nid="b" x="200" y="0"',
    'id="ab" from="a" to="b" numLanes="2" speed="13.9"\nid="ba" from="b" to="a" numLanes="1" speed="13.9"',
)
# A right-angled bend whose internal lanes are curved, and a straight on behind it.
BEND = (
    'id="a" x="0" y="0"\nid="b" x="100" y="0"\nid="c" x="100" y="100"\nid="d" x="200" y="0"',
    'id="ab" from="a" to="b" speed="13.9"\nid="bc" from="b" to="c" speed="13.9"\nid="bd" from="b" to="d" speed="13.9"',
)
THREE_LANES = (
    'id="a" x="0" y="0"\nid="b" x="1000" y="0"',
    'id="ab" from="a" to="b" numLanes="3" width="3.2" speed="33.3"',
)


def arc(radius_m: float, left: bool = True, pieces: int = 1200, turn_rad: float = pi / 2) -> tuple[str, str]:
    """One lane that begins eastwards at the origin and turns by `turn_rad` on a circle."""
    side = 1.0 if left else -1.0
    angles = [turn_rad * k / pieces for k in range(pieces + 1)]
    points = [(radius_m * sin(a), side * radius_m * (1.0 - cos(a))) for a in angles]
    shape = " ".join(f"{x:.9f},{y:.9f}" for x, y in points)
    end = f'id="b" x="{points[-1][0]:.9f}" y="{points[-1][1]:.9f}"'
    return f'id="a" x="0" y="0"\n{end}', f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'


def match(
    hd_map: HDMap, mode: int, lane: str, x_m: float, y_m: float, heading_rad: float, layer: int = 0
) -> tuple[int, float]:
    """Segment and offset of one position."""
    found = MatchedOffsets(np.zeros(1, np.int32), np.zeros(1))
    at, here, heading = np.array([hd_map.lane_index[lane]], np.int32), np.array([[x_m, y_m]]), np.array([heading_rad])
    offsets(hd_map.lanes, hd_map.index, mode, layer, at, here, heading, found)
    return int(found.segment[0]), float(found.offset_m[0])


def segment_line(lanes: MapArrays, segment: int, extend: bool, beyond_m: float = 1e4) -> shapely.LineString:
    """A segment as shapely sees it, with the ends that nothing is joined to drawn out where `extend`."""
    start = np.array([lanes.x0_m[segment], lanes.y0_m[segment]])
    unit = np.array([lanes.dx[segment], lanes.dy[segment]])
    end = start + unit * lanes.length_m[segment]
    if extend and lanes.open_start[segment]:
        start = start - unit * beyond_m
    if extend and lanes.open_end[segment]:
        end = end + unit * beyond_m
    return shapely.LineString([start, end])


def net_text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
