"""Centre lines of OpenDRIVE lanes."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.opendrive.numbers import FARTHEST_M, LONGEST_M, WIDEST_M
from gpsec.opendrive.polylines import stations
from gpsec.opendrive.road import LaneSection, Road, RoadLane

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
# As share of the reference line's length; points are taken as they are where a lane is as long as that.
_SAME_LENGTH = 0.02


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
    """Yield the centre line of every lane of these kinds, with points about `spacing_m` apart along it or closer."""
    for road in roads:
        for number, section in enumerate(road.sections):
            if any(lane.kind in kinds for lane in section.lanes):
                for side in (1, -1):
                    yield from _of_side(road, number, side, spacing_m, kinds)


def _of_side(road: Road, number: int, side: int, spacing_m: float, kinds: frozenset[str]) -> Iterator[CentreLine]:
    section = road.sections[number]
    pieces = max(1, int(np.ceil((section.end_m - section.begin_m) / spacing_m)))
    # What is written at the end of the section is the beginning of the next one.
    station = np.minimum(np.linspace(section.begin_m, section.end_m, pieces + 1), section.end_m - _BEFORE_END_M)
    for place, lane in enumerate(_centres(road, section, side, station)):
        if lane.of.kind not in kinds:
            continue
        along, here = _evenly(station, lane.points_m, spacing_m), lane
        if along is not station:
            here = list(_centres(road, section, side, along))[place]
        ahead = ((side < 0) != road.left_hand) != lane.of.reversed
        order = slice(None) if ahead else slice(None, None, -1)
        yield CentreLine(
            road.road_id,
            number,
            lane.of.lane_id,
            lane.of.kind,
            along[order],
            here.points_m[order],
            _directions(here.points_m[order]),
            here.width_m[order],
            number + (1 if ahead else -1),
            lane.of.behind if ahead else lane.of.before,
        )


class _Centre(NamedTuple):
    """Centre (n, 2) and width (n,) of a lane at n stations."""

    of: RoadLane
    points_m: Floats
    width_m: Floats


def _centres(road: Road, section: LaneSection, side: int, station: Floats) -> Iterator[_Centre]:
    """Yield the lanes of one side from the centre lane outwards, at (n,) stations of the road."""
    points, heading = road.reference(station)
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
    tilt = np.cos(road.superelevation.at(station))
    inner = road.lane_offset.at(station) * tilt
    lanes = [lane for lane in section.lanes if lane.lane_id * side > 0]
    for lane in sorted(lanes, key=lambda lane: abs(lane.lane_id)):
        width = np.maximum(lane.width.at(station - section.begin_m), 0.0)
        across = side * (width if lane.level else width * tilt)
        yield _Centre(lane, points + (inner + 0.5 * across)[:, None] * left, width)
        inner = inner + across


def _evenly(station: Floats, points: Floats, spacing_m: float) -> Floats:
    """Return stations at which points lie at most `spacing_m` apart; the same ones where they already do.

    On the outer side of a tight curve a lane is many times as long as the reference line, on the inner side shorter.
    """
    way = stations(points)
    stretch = np.diff(way) / np.maximum(np.diff(station), _BEFORE_END_M)
    if not 0.0 < way[-1] <= LONGEST_M or np.abs(stretch - 1.0).max() < _SAME_LENGTH:
        return station
    pieces = max(1, int(np.ceil(way[-1] / spacing_m)))
    even: Floats = np.interp(np.linspace(0.0, way[-1], pieces + 1), way, station)
    return even


def check_centre_lines(lines: list[CentreLine], map_file: Path) -> None:
    """Check that lanes are where roads can be, and as wide as one can be.

    Raises:
        GpsecError: one is not; it is named.
    """
    for line in lines:
        where = f"{map_file}: road '{shown(line.road_id)}': lane {line.lane_id} at s={line.station_m.min():g}"
        if not np.abs(line.points_m).max() <= FARTHEST_M or not stations(line.points_m)[-1] <= LONGEST_M:
            raise GpsecError(f"{where}: expected a place on the Earth and at most {LONGEST_M:g} m of way")
        if not line.width_m.max() <= WIDEST_M:
            raise GpsecError(f"{where}: expected a width of at most {WIDEST_M:g} m, found {line.width_m.max():g}")


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
