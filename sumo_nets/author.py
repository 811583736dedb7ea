"""Turns a plan into OpenDRIVE with the scenariogeneration library."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from scenariogeneration import xodr
from scenariogeneration.helpers import printToFile

from sumo_nets.alignment import Alignment, Pose, fillet
from sumo_nets.plan import FIRST_CONNECTING_ID, Arm, Junction, LaneLink, Plan, Section, Street
from sumo_nets.turns import lane_links, major_arms

DATE = "2026-01-01T00:00:00"
"""The header's date is fixed, so that the same plan gives the same bytes."""

TRAFFIC_LIGHT, PRIORITY_ROAD, GIVE_WAY = "1000001", "306", "205"
"""Signal types of the German catalogue, which netconvert understands."""


class SpeedLane(xodr.Lane):  # type: ignore[misc]
    """A driving lane with a speed limit: netconvert drops a limit that is given for the whole road."""

    def __init__(
        self, width_m: float, speed_mps: float, end_width_m: float | None = None, length_m: float = 1.0
    ) -> None:
        """Constant width, or one that changes smoothly to `end_width_m` over `length_m`."""
        change = 0.0 if end_width_m is None else end_width_m - width_m
        super().__init__(
            lane_type=xodr.LaneType.driving,
            a=width_m,
            c=round(3.0 * change / length_m**2, 9),
            d=round(-2.0 * change / length_m**3, 9),
        )
        self.speed_mps = speed_mps

    def get_element(self) -> ElementTree.Element:
        """Return the library's element, with the speed limit."""
        element: ElementTree.Element = super().get_element()
        ElementTree.SubElement(element, "speed", attrib={"sOffset": "0", "max": str(self.speed_mps), "unit": "m/s"})
        return element


def write(plan: Plan, path: Path) -> None:
    """Write a plan as an OpenDRIVE file."""
    drive = xodr.OpenDrive(plan.name, revMinor="6", geo_reference=f"<![CDATA[{plan.geo_reference}]]>")
    roads = {street.id: _road(street) for street in plan.streets}
    for road in roads.values():
        drive.add_road(road)
    connecting_id = FIRST_CONNECTING_ID
    for junction in plan.junctions:
        arms = plan.arms(junction)
        element = xodr.Junction(junction.name, junction.id)
        for link in lane_links(junction, arms):
            entry = next(arm for arm in arms if arm.street.id == link.from_street and arm.lanes_in)
            leave = next(arm for arm in arms if arm.street.id == link.to_street and arm.lanes_out)
            road = _connecting_road(connecting_id, junction.id, link, entry, leave)
            drive.add_road(road)
            connection = xodr.Connection(link.from_street, connecting_id, xodr.ContactPoint.start)
            connection.add_lanelink(entry.lane_id(link.from_lane, entering=True), -1)
            element.add_connection(connection)
            connecting_id += 1
        drive.add_junction(element)
        _add_signals(junction, arms, roads)
    root = drive.get_element()
    root.find("header").set("date", DATE)
    printToFile(root, str(path), prettyprint=True, encoding="utf-8")


def _road(street: Street) -> xodr.Road:
    """Return a street as a road with its lane sections, linked to its junctions."""
    lanes = xodr.Lanes()
    for index, section in enumerate(street.sections):
        before = street.sections[index - 1] if index else None
        after = street.sections[index + 1] if index + 1 < len(street.sections) else None
        lanes.add_lanesection(_lane_section(street, section, before, after))
    road = xodr.Road(street.id, planview(street.alignment), lanes, name=street.name)
    if street.start is not None:
        road.add_predecessor(xodr.ElementType.junction, street.start)
    if street.end is not None:
        road.add_successor(xodr.ElementType.junction, street.end)
    return road


def _lane_section(street: Street, section: Section, before: Section | None, after: Section | None) -> xodr.LaneSection:
    """Lanes of a section; lanes of neighbouring sections with the same id continue each other."""
    two_way = min(section.lanes) > 0
    mark = xodr.std_roadmark_solid_solid() if two_way and max(section.lanes) > 1 else xodr.std_roadmark_broken()
    centre = xodr.Lane(lane_type=xodr.LaneType.none)
    centre.add_roadmark(mark if two_way else xodr.std_roadmark_solid())
    result = xodr.LaneSection(_rounded(section.s), centre)
    for side, count in enumerate(section.lanes):
        for number in range(1, count + 1):
            lane = SpeedLane(street.width_m, section.speed_mps)
            lane.add_roadmark(xodr.std_roadmark_solid() if number == count else xodr.std_roadmark_broken())
            lane_id = number if side else -number
            if before is not None and number <= before.lanes[side]:
                lane.add_link("predecessor", lane_id)
            if after is not None and number <= after.lanes[side]:
                lane.add_link("successor", lane_id)
            if side:
                result.add_left_lane(lane)
            else:
                result.add_right_lane(lane)
    return result


def _connecting_road(road_id: int, junction_id: int, link: LaneLink, entry: Arm, leave: Arm) -> xodr.Road:
    """Return a one-lane road across a junction; its reference line is the lane's left border."""
    start, end = entry.border(link.from_lane, entering=True), leave.border(link.to_lane, entering=False)
    alignment = fillet(start, end)
    view = planview(alignment) if alignment else _bend(start, end)
    length = view.get_total_length()
    lane = SpeedLane(entry.street.width_m, _crossing_speed(entry, leave), leave.street.width_m, max(float(length), 1.0))
    lane.add_link("predecessor", entry.lane_id(link.from_lane, entering=True))
    lane.add_link("successor", leave.lane_id(link.to_lane, entering=False))
    centre = xodr.Lane(lane_type=xodr.LaneType.none)
    lanes = xodr.Lanes()
    lanes.add_lanesection(xodr.LaneSection(0.0, centre).add_right_lane(lane))
    road = xodr.Road(road_id, view, lanes, road_type=junction_id)
    for arm, add in ((entry, road.add_predecessor), (leave, road.add_successor)):
        contact = xodr.ContactPoint.end if arm.at_end else xodr.ContactPoint.start
        add(xodr.ElementType.road, arm.street.id, contact)
    return road


def _crossing_speed(entry: Arm, leave: Arm) -> float:
    """Speed limit across a junction: the lower one of the two streets."""
    incoming = entry.street.sections[-1 if entry.at_end else 0]
    outgoing = leave.street.sections[-1 if leave.at_end else 0]
    return min(incoming.speed_mps, outgoing.speed_mps)


def planview(alignment: Alignment) -> xodr.PlanView:
    """Return an alignment as a plan view, rounded to a micrometre so that every machine writes the same digits."""
    view = xodr.PlanView()
    s = 0.0
    for segment in alignment.segments:
        length = _rounded(segment.length)
        k0, k1 = round(segment.k0, 12), round(segment.k1, 12)
        if k0 == 0.0 and k1 == 0.0:
            shape = xodr.Line(length)
        elif abs(k0 - k1) < 1e-9:
            shape = xodr.Arc(k0, length=length)
            shape.length = length
        else:
            shape = xodr.Spiral(k0, k1, length=length)
        heading = round(math.atan2(math.sin(segment.heading), math.cos(segment.heading)), 9)
        view.add_fixed_geometry(shape, _rounded(segment.x), _rounded(segment.y), heading, _rounded(s))
        s = _rounded(s + length)
    view.present_s = s
    return view


def _bend(start: Pose, end: Pose) -> xodr.PlanView:
    """Return a cubic (Hermite) from pose to pose, for shifts and turns that one curve cannot make."""
    cos, sin = math.cos(start[2]), math.sin(start[2])
    along = (end[0] - start[0]) * cos + (end[1] - start[1]) * sin
    aside = (end[1] - start[1]) * cos - (end[0] - start[0]) * sin
    turned = end[2] - start[2]
    pull = math.hypot(along, aside)
    end_u, end_v = pull * math.cos(turned), pull * math.sin(turned)
    shape = xodr.ParamPoly3(
        0.0,
        _rounded(pull),
        _rounded(3.0 * along - 2.0 * pull - end_u),
        _rounded(pull + end_u - 2.0 * along),
        0.0,
        0.0,
        _rounded(3.0 * aside - end_v),
        _rounded(end_v - 2.0 * aside),
    )
    shape.length = _rounded(float(shape.length))
    view = xodr.PlanView()
    heading = round(math.atan2(math.sin(start[2]), math.cos(start[2])), 9)
    view.add_fixed_geometry(shape, _rounded(start[0]), _rounded(start[1]), heading, 0.0)
    view.present_s = shape.length
    return view


def _add_signals(junction: Junction, arms: list[Arm], roads: dict[int, xodr.Road]) -> None:
    """Put a traffic light or a sign at every lane that enters a junction."""
    majors = major_arms(arms)
    for index, arm in enumerate(arms):
        if not arm.lanes_in:
            continue
        sign = PRIORITY_ROAD if arm in majors else GIVE_WAY
        kind = TRAFFIC_LIGHT if junction.control == "signals" else sign
        length = arm.street.alignment.length
        offset = (arm.lanes_in * arm.street.width_m + 0.5) * (-1 if arm.at_end else 1)
        signal = xodr.Signal(
            s=_rounded(length - 0.5 if arm.at_end else 0.5),
            t=_rounded(offset),
            country="DE",
            Type=kind,
            id=f"{junction.id}{index:02d}",
            name=junction.name,
            dynamic=xodr.Dynamic.yes if kind == TRAFFIC_LIGHT else xodr.Dynamic.no,
            orientation=xodr.Orientation.positive if arm.at_end else xodr.Orientation.negative,
        )
        # Not add_signal(): it numbers signals across all networks of a process.
        roads[arm.street.id].signals.append(signal)


def _rounded(value: float) -> float:
    """Round to a micrometre, without a negative zero."""
    return round(value, 6) + 0.0
