"""Paths through junctions: which lanes of a net make one, and which way of the map they follow."""

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.opendrive.extents import Extent
from gpsec.opendrive.netfile import NetLane
from gpsec.opendrive.polylines import at_stations, spread, stations
from gpsec.opendrive.ways import Ways, joined

_MOVED_M = 5.0
_CLOSEST_M = 0.2


@dataclass(frozen=True)
class Chain:
    """Lanes of a net that lead from one road to another, by index.

    Attributes:
        lanes: inside the junction, in driving order; most often there is one.
        before, behind: outside, None where nothing leads to or on from them.
        link: the connection that they carry out.
    """

    lanes: tuple[int, ...]
    before: int | None
    behind: int | None
    link: Element


def chains(root: Element, lanes: list[NetLane]) -> Iterator[Chain]:
    """Yield the paths through the junctions of a net."""
    number = {lane.lane_id: index for index, lane in enumerate(lanes) if len(lane.points_m) > 1}
    after: dict[int, int] = {}
    firsts: dict[int, tuple[int, Element]] = {}
    for link in root.iterfind("connection"):
        source = number.get(f"{link.get('from')}_{link.get('fromLane')}")
        target = number.get(link.get("via") or f"{link.get('to')}_{link.get('toLane')}")
        if source is None or target is None:
            continue
        if lanes[source].internal:
            after[source] = target
        elif lanes[target].internal:
            firsts[target] = source, link
    for first, (before, link) in firsts.items():
        chain, lane = [first], after.get(first)
        while lane is not None and lanes[lane].internal and lane not in chain:
            chain.append(lane)
            lane = after.get(lane)
        yield Chain(tuple(chain), before, lane if lane is not None and not lanes[lane].internal else None, link)


def through(
    chain: Chain, lanes: list[NetLane], before: Extent | None, behind: Extent | None, ways: Ways
) -> dict[int, Floats]:
    """Return the shapes of a chain's lanes where the map's ways lead from road to road, none where they do not.

    They follow what the junction takes of the first road, the map's own way through it, and what it takes of the other.
    """
    if before is None or behind is None:
        return {}
    if before.way is behind.way:
        if behind.begin_m - before.finish_m < _CLOSEST_M:
            return {}
        return _cut(before.way.piece(before.finish_m, behind.begin_m), chain, lanes)
    head = before.way.piece(before.finish_m, before.way.length_m)
    tail = behind.way.piece(0.0, behind.begin_m)
    names = dict.fromkeys(lanes[lane].original for lane in chain.lanes if lanes[lane].original)
    inside = [[way.points_m] for name in names for way in ways.named(name)]
    lines = [line for middle in (inside or [[]]) if (line := joined([head, *middle, tail])) is not None]
    return _cut(min(lines, key=_length), chain, lanes) if lines else {}


def along_way(
    chain: Chain, lanes: list[NetLane], start: Floats | None, end: Floats | None, ways: Ways
) -> dict[int, Floats]:
    """Return the shapes of a chain's lanes along the map's way between the roads, none where there is no such way.

    Where the chain has several lanes, they meet where they met, in proportion to their lengths.
    """
    name = next((lanes[lane].original for lane in chain.lanes if lanes[lane].original), "")
    if start is None or end is None or not name:
        return {}
    way = ways.between(name, start, end)
    return {} if way is None else _cut(way, chain, lanes)


def blended(chain: Chain, lanes: list[NetLane], start: Floats | None, end: Floats | None) -> dict[int, Floats]:
    """Return the shapes of a chain's lanes with their ends moved to those of the roads, the rest in proportion.

    Where they would be moved far, they go straight from the one to the other.
    """
    points = np.concatenate([lanes[lane].points_m for lane in chain.lanes])
    shift = [to - point if to is not None else np.zeros(2) for to, point in ((start, points[0]), (end, points[-1]))]
    if max(np.hypot(*move) for move in shift) > _MOVED_M:
        return _cut(np.array([points[0] + shift[0], points[-1] + shift[1]]), chain, lanes)
    way = stations(points)
    share = (way / max(way[-1], _CLOSEST_M))[:, None]
    return _cut(points + (1.0 - share) * shift[0] + share * shift[1], chain, lanes)


def _cut(way: Floats, chain: Chain, lanes: list[NetLane]) -> dict[int, Floats]:
    """Divide a line among a chain's lanes in proportion to their lengths."""
    length = np.array([max(_length(lanes[lane].points_m), _CLOSEST_M) for lane in chain.lanes])
    place = stations(way)
    marks = np.concatenate([[0.0], np.cumsum(length)]) / length.sum() * place[-1]
    shapes = {}
    for lane, low, high in zip(chain.lanes, marks[:-1], marks[1:], strict=True):
        inside = way[(place > low + _CLOSEST_M) & (place < high - _CLOSEST_M)]
        first, last = at_stations(way, np.array([low, high]))
        shapes[lane] = spread([first, *inside, last], 0.5 * _CLOSEST_M)
    return shapes


def _length(line: Floats) -> float:
    return float(stations(line)[-1])
