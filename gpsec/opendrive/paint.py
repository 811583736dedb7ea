"""Which lanes of a map have a line on either side: road marks of OpenDRIVE, given to the lanes of the net."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.opendrive.compare import Matches
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.netfile import NetLane
from gpsec.opendrive.road import LaneSection, Road, RoadLane
from gpsec.opendrive.sections import lane_number
from gpsec.types.paint import PaintedLane

# What bounds a lane without being a line that is painted.
_NO_PAINT = frozenset(["none", "curb", "grass", "edge", "custom", ""])


@dataclass(frozen=True)
class Border:
    """One side of a lane.

    Attributes:
        offset_m: (n,) from the beginning of the section, ascending, from where on a mark holds.
        painted: (n,) it is a line; a broken one is one.
    """

    offset_m: Floats
    painted: Flags

    def at(self, offset_m: Floats) -> Flags:
        """Return (m,) whether there is a line at distances from the beginning of the section."""
        piece = np.searchsorted(self.offset_m, offset_m + 1e-9, side="right") - 1
        found: Flags = (piece >= 0) & self.painted[np.maximum(piece, 0)] if len(self.painted) else offset_m < -np.inf
        return found


# A lane that the map leaves out, such as lane 0: an id() that no element has, and its border.
_NOBODY = 0
_UNMARKED = Border(np.zeros(0), np.zeros(0, np.bool_))


def borders(root: Element) -> dict[int, Border]:
    """Return the outer border of each lane element, by its id(); that of lane 0 is the reference line."""
    return {id(lane): _border(lane) for section in root.iter("laneSection") for lane in section.iter("lane")}


def _border(lane: Element) -> Border:
    marks = [
        (_number(mark.get("sOffset")), mark.get("type", "none") not in _NO_PAINT) for mark in lane.iterfind("roadMark")
    ]
    marks.sort(key=lambda mark: mark[0])
    return Border(np.array([offset for offset, _ in marks]), np.array([painted for _, painted in marks], np.bool_))


def _number(text: str | None) -> float:
    try:
        return float(text or 0.0)
    except ValueError:
        return 0.0


def sides(lines: list[CentreLine], roads: list[Road], root: Element) -> tuple[Flags, Flags]:
    """Return (n,) whether there is a line to the left and to the right of each point of the lines, in driving order."""
    known = borders(root)
    reference = {
        id(lane): next((id(other) for other in section.iter("lane") if lane_number(other) == 0), _NOBODY)
        for section in root.iter("laneSection")
        for lane in section.iter("lane")
    }
    by_name = {road.road_id: road for road in roads}
    left, right = [], []
    for line in lines:
        road = by_name[line.road_id]
        section = road.sections[line.section]
        lane = next(one for one in section.lanes if one.lane_id == line.lane_id)
        offset_m = line.station_m - section.begin_m
        outer = known[id(lane.element)].at(offset_m)
        inner = known.get(_inner(section, lane, reference), _UNMARKED).at(offset_m)
        outwards = (road.left_hand) != lane.reversed  # to the left of who drives there
        left.append(outer if outwards else inner)
        right.append(inner if outwards else outer)
    return np.concatenate(left), np.concatenate(right)


def _inner(section: LaneSection, lane: RoadLane, reference: Mapping[int, int]) -> int:
    """Return id() of the element whose outer border is the inner one of a lane; `_NOBODY` where the map has none."""
    inner = lane.lane_id - (1 if lane.lane_id > 0 else -1)
    beside = next((one for one in section.lanes if one.lane_id == inner), None)
    return id(beside.element) if beside is not None else reference[id(lane.element)]


def painted_lanes(matches: Matches, left: Flags, right: Flags, lanes: list[NetLane]) -> Iterator[PaintedLane]:
    """Yield the stretches of the net's lanes that have the same lines, lane by lane, from points beside them."""
    for number, lane in enumerate(lanes):
        mine = np.flatnonzero(matches.lane == number)
        if lane.internal or not len(mine):
            continue
        mine = mine[np.argsort(matches.along_m[mine], kind="stable")]
        along_m = matches.along_m[mine]
        kind = 2 * left[mine].astype(int) + right[mine]
        change = np.flatnonzero(np.diff(kind)) + 1
        length_m = float(np.hypot(*np.diff(lane.points_m, axis=0).T).sum())
        begin = [0.0, *(0.5 * (along_m[change] + along_m[change - 1])).tolist()]
        for at, begins_m, ends_m in zip([0, *change.tolist()], begin, [*begin[1:], length_m], strict=True):
            yield PaintedLane(lane.lane_id, begins_m, ends_m, bool(left[mine[at]]), bool(right[mine[at]]))
