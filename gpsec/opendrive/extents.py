"""Where on their ways the lanes of a net begin and end: all lanes of one edge on the same piece of road.

netconvert cuts every lane where it meets the edge of a junction. In a tight turn a lane may meet it twice, and little
is left of it; beside a junction that lies askew, each lane of an edge is cut elsewhere. SUMO counts positions along an
edge for all of its lanes alike.
"""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.opendrive.netfile import NetLane, by_edge
from gpsec.opendrive.ways import Way, WayPiece, Ways

# Of the longest lane of an edge; what is shorter says nothing of where the edge begins and ends.
_SHARE_OF_LONGEST = 0.5
# Of the lane section; where an edge has less, nothing of it can be told.
_SHARE_OF_SECTION = 0.1
_SHORTEST_M = 1e-3
# A lane that runs so far against its way is one of the other direction.
_BACKWARDS_M = 1.0


@dataclass(frozen=True)
class Extent:
    """Which piece of a way a lane is, by lengths along it."""

    way: Way
    begin_m: float
    finish_m: float

    def shape(self) -> Floats:
        """Return the (n, 2) points of the piece."""
        return self.way.piece(self.begin_m, self.finish_m)


def extents(lanes: list[NetLane], ways: Ways) -> dict[int, Extent]:
    """Return where the lanes outside junctions begin and end, by index; lanes without a way are not among them."""
    parts = {
        index: part
        for index, lane in enumerate(lanes)
        if not lane.internal and len(lane.points_m) > 1 and (part := ways.beside(lane.original, lane.points_m))
        if _backwards(part, lane) < _BACKWARDS_M
    }
    edges = list(by_edge(lanes).values())
    used: dict[int, int] = {}
    for edge in edges:
        for number in {id(parts[index]) for index in edge if index in parts}:
            used[number] = used.get(number, 0) + 1
    found = {}
    for edge in edges:
        ends = {index: _ends(parts[index], lanes[index]) for index in edge if index in parts}
        alone = all(used[id(parts[index])] == 1 for index in ends)
        begin, finish = _common(list(ends.values()), [parts[index] for index in ends], alone)
        for index in ends:
            way, middle = parts[index].way, 0.5 * (begin + finish)
            if not parts[index].low_m <= middle <= parts[index].high_m:
                way = ways.over(lanes[index].original, middle) or way
            extent = Extent(way, way.along(begin), way.along(finish))
            if extent.finish_m - extent.begin_m > _SHORTEST_M:
                found[index] = extent
    return found


def _ends(part: WayPiece, lane: NetLane) -> tuple[float, float]:
    """Return the stations at which a lane begins and ends."""
    return part.way.station(lane.points_m[0]), part.way.station(lane.points_m[-1])


def _backwards(part: WayPiece, lane: NetLane) -> float:
    """Return the length for which a lane runs against the way beside it."""
    begin, finish = _ends(part, lane)
    return part.way.along(begin) - part.way.along(finish)


def _common(ends: list[tuple[float, float]], parts: list[WayPiece], alone: bool) -> tuple[float, float]:
    """Return the stations at which all lanes of an edge begin and end.

    They are the medians of the lanes that have kept most of their length. Where none has any, it is all of the lane
    section, provided that the edge is `alone` there.
    """
    if not ends:
        return 0.0, 0.0
    length = np.array([abs(finish - begin) for begin, finish in ends])
    section = max(part.high_m - part.low_m for part in parts)
    if alone and length.max() < _SHARE_OF_SECTION * section:
        way, low, high = parts[0].way, parts[0].low_m, parts[0].high_m
        return (low, high) if way.along(high) > way.along(low) else (high, low)
    kept = [pair for pair, long in zip(ends, length, strict=True) if long >= _SHARE_OF_LONGEST * length.max()]
    begin, finish = np.median(np.array(kept), axis=0)
    return float(begin), float(finish)
