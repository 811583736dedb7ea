"""Motorways: two carriageways along one centre line, with off- and on-ramps that have lanes to change speed on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from sumo_nets.alignment import Alignment, Pose, drive, through
from sumo_nets.plan import LaneLink, Lanes, Plan, Street

MEDIAN_M = 5.0
NOSE_M = 36.0
"""Length of the junction in which a ramp leaves or joins."""

RAMP_ANGLE_RAD = math.radians(4.0)
RAMP_GAP_M = 1.2

Steps = Sequence[float | tuple[float, float]]


@dataclass(frozen=True)
class Ramp:
    """A ramp at a station (m) of its carriageway; `steps` lead away from the motorway, turns to the right negative."""

    s: float
    leaves: bool
    steps: Steps
    extra_lane_m: float = 400.0


@dataclass(frozen=True)
class Carriageway:
    """One direction of a motorway: base lanes by station, and ramps in the order of driving."""

    name: str
    lanes: Sequence[tuple[float, int]]
    ramps: Sequence[Ramp]
    speed_kmh: float
    width_m: float

    def base_lanes(self, s: float) -> int:
        """Lanes at a station, without those of the ramps."""
        return [count for at, count in self.lanes if at <= s][-1]


def offset_points(points: Sequence[Sequence[float]], right_m: float) -> list[tuple[float, ...]]:
    """Points of intersection of the line that runs `right_m` to the right, with radii that keep the distance."""
    result: list[tuple[float, ...]] = []
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in itertools.pairwise(points)]
    for index, point in enumerate(points):
        before = headings[max(index - 1, 0)]
        after = headings[min(index, len(headings) - 1)]
        half = 0.5 * math.atan2(math.sin(after - before), math.cos(after - before))
        reach = right_m / math.cos(half)
        x, y = point[0] + reach * math.sin(before + half), point[1] - reach * math.cos(before + half)
        radius = (point[2] + math.copysign(right_m, half),) if len(point) > 2 else ()
        result.append((x, y, *radius))
    return result


def lay(plan: Plan, points: Sequence[Sequence[float]], forward: Carriageway, backward: Carriageway) -> None:
    """Add both carriageways along points of intersection."""
    _lay_carriageway(plan, through(offset_points(points, MEDIAN_M / 2.0)), forward)
    _lay_carriageway(plan, through(offset_points(list(reversed(points)), MEDIAN_M / 2.0)), backward)


def _lay_carriageway(plan: Plan, line: Alignment, way: Carriageway) -> None:
    """Cut a carriageway at its ramps and link the pieces."""
    begin, before = 0.0, None
    entry: tuple[Ramp, Street, Street] | None = None
    for number, ramp in enumerate([*way.ramps, None], start=1):
        end = line.length if ramp is None else ramp.s - (0.0 if ramp.leaves else NOSE_M)
        junction = None if ramp is None else plan.junction(f"{way.name} ramp {number}", "merge")
        piece = plan.street(
            f"{way.name} {number}",
            line.slice(begin, end),
            lanes=_piece_lanes(way, begin, end, entry[0] if entry else None, ramp),
            speed_kmh=way.speed_kmh,
            width_m=way.width_m,
            rank=3,
            start=before,
            end=junction,
        )
        if entry:
            _link(plan, f"{way.name} ramp {number - 1}", way, *entry, piece)
        if ramp is None or junction is None:
            return
        entry = (ramp, piece, _add_ramp(plan, line, way, ramp, number, junction))
        begin, before = end + NOSE_M, junction


def _piece_lanes(
    way: Carriageway, begin: float, end: float, entry: Ramp | None, leave: Ramp | None
) -> list[tuple[float, Lanes]]:
    """Lanes along a piece: the base lanes, one more behind an on-ramp and before an off-ramp."""
    stations = {begin} | {at for at, _ in way.lanes if begin < at < end}
    merge_end = begin + entry.extra_lane_m if entry and not entry.leaves else begin
    exit_begin = end - leave.extra_lane_m if leave and leave.leaves else end
    if merge_end >= exit_begin - 60.0:
        merge_end = exit_begin = end
    stations |= {s for s in (merge_end, exit_begin) if begin < s < end}
    result: list[tuple[float, Lanes]] = []
    for s in sorted(stations):
        extra = 1 if s < merge_end or s >= exit_begin else 0
        result.append((s - begin, (way.base_lanes(s) + extra, 0)))
    return result


def _add_ramp(plan: Plan, line: Alignment, way: Carriageway, ramp: Ramp, number: int, junction: int) -> Street:
    """Lay a ramp's road beside the main one."""
    at = ramp.s + NOSE_M if ramp.leaves else ramp.s - NOSE_M
    x, y, heading = line.pose_at(at)
    aside = way.base_lanes(at) * way.width_m + RAMP_GAP_M
    x, y = x + aside * math.sin(heading), y - aside * math.cos(heading)
    pose: Pose = (x, y, heading - RAMP_ANGLE_RAD)
    alignment = drive(pose, ramp.steps)
    if not ramp.leaves:
        mirrored = [(-step[0], step[1]) if isinstance(step, tuple) else step for step in ramp.steps]
        alignment = drive((x, y, heading + math.pi + RAMP_ANGLE_RAD), mirrored).reversed()
    return plan.street(
        f"{way.name} ramp {number}",
        alignment,
        lanes=(1, 0),
        speed_kmh=min(80.0, way.speed_kmh),
        width_m=way.width_m,
        rank=1,
        start=junction if ramp.leaves else None,
        end=None if ramp.leaves else junction,
    )


def _link(plan: Plan, name: str, way: Carriageway, ramp: Ramp, before: Street, road: Street, after: Street) -> None:
    """Connect the lanes where a ramp leaves or joins."""
    base = way.base_lanes(ramp.s)
    if ramp.leaves:
        links = [LaneLink(before.id, 0, road.id, 0)]
        links += [LaneLink(before.id, lane + 1, after.id, lane) for lane in range(base)]
    else:
        links = [LaneLink(road.id, 0, after.id, 0)]
        links += [LaneLink(before.id, lane, after.id, lane + 1) for lane in range(base)]
    plan.merge(name, links)
