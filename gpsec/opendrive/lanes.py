"""Centre lines of OpenDRIVE lanes."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gpsec.arrays import Floats
from gpsec.opendrive.road import LaneSection, Road

# Lanes that traffic drives on; parking, stopping, cycling, walking and the rest are none.
DRIVEN = frozenset(
    [
        "driving",
        "entry",
        "exit",
        "onRamp",
        "offRamp",
        "connectingRamp",
        "slipLane",
        "bidirectional",
        "mwyEntry",
        "mwyExit",
        "HOV",
        "bus",
        "taxi",
    ]
)
# What else netconvert makes lanes of that cars may use.
IMPORTED = DRIVEN | {"stop", "parking"}
# A lane that is just opening or closing has no place for a vehicle, and netconvert leaves it out.
NARROWEST_M = 1.8
_BEFORE_END_M = 1e-7


@dataclass(frozen=True)
class CentreLine:
    """The centre of one lane of one lane section, in driving order.

    Attributes:
        road_id, section, lane_id: which lane it is; `section` counts the road's lane sections.
        kind: the lane's type.
        station_m: (n,) along the road.
        points_m: (n, 2) in the map's frame.
        heading_rad: (n,) direction of travel.
        width_m: (n,) of the lane.
        next_section, next_lane: which lane of the same road it leads to, None where it leads to none.
    """

    road_id: str
    section: int
    lane_id: int
    kind: str
    station_m: Floats
    points_m: Floats
    heading_rad: Floats
    width_m: Floats
    next_section: int
    next_lane: int | None


def centre_lines(roads: list[Road], spacing_m: float, kinds: frozenset[str] = DRIVEN) -> Iterator[CentreLine]:
    """Yield the centre line of every lane of these kinds, with points at most `spacing_m` apart along the road."""
    for road in roads:
        for number, section in enumerate(road.sections):
            yield from _of_section(road, number, section, spacing_m, kinds)


def _of_section(
    road: Road, number: int, section: LaneSection, spacing_m: float, kinds: frozenset[str]
) -> Iterator[CentreLine]:
    if not any(lane.kind in kinds for lane in section.lanes):
        return
    pieces = max(1, int(np.ceil((section.end_m - section.begin_m) / spacing_m)))
    # What is written at the end of the section is the beginning of the next one.
    station = np.minimum(np.linspace(section.begin_m, section.end_m, pieces + 1), section.end_m - _BEFORE_END_M)
    points, heading = road.reference(station)
    across = np.cos(road.superelevation.at(station))
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
    for side in (1, -1):
        centre_lane = inner = road.lane_offset.at(station)
        lanes = [lane for lane in section.lanes if lane.lane_id * side > 0]
        ahead = (side < 0) != road.left_hand
        order = slice(None) if ahead else slice(None, None, -1)
        for lane in sorted(lanes, key=lambda lane: abs(lane.lane_id)):
            distance = station - section.begin_m
            if lane.width is not None:
                width = lane.width.at(distance)
            else:
                width = side * (centre_lane + lane.border.at(distance) - inner)
            width = np.maximum(width, 0.0)
            centre = points + ((inner + 0.5 * side * width) * across)[:, None] * left
            inner = inner + side * width
            if lane.kind in kinds:
                yield CentreLine(
                    road.road_id,
                    number,
                    lane.lane_id,
                    lane.kind,
                    station[order],
                    centre[order],
                    _directions(centre[order]),
                    width[order],
                    number + (1 if ahead else -1),
                    lane.behind if ahead else lane.before,
                )


def _directions(points: Floats) -> Floats:
    """Return (n,) directions of a line: at each point, from the one before to the one behind."""
    ahead = np.gradient(points, axis=0)
    heading: Floats = np.arctan2(ahead[:, 1], ahead[:, 0])
    return heading


def paths(lines: list[CentreLine]) -> Iterator[list[CentreLine]]:
    """Yield the ways through each road: lanes that lead on to each other through its sections, in driving order."""
    known = {(line.road_id, line.section, line.lane_id): line for line in lines}
    led_to = {(line.road_id, line.next_section, line.next_lane) for line in lines}
    for start in lines:
        if (start.road_id, start.section, start.lane_id) in led_to:
            continue
        path, line = [], known.get((start.road_id, start.section, start.lane_id))
        while line is not None:
            path.append(line)
            line = known.get((line.road_id, line.next_section, line.next_lane or 0))
        yield path
