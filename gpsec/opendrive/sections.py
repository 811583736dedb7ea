"""Lane sections of a map, put in the form that netconvert reads.

netconvert counts lanes in the order in which they are written, whatever their ids: on the left from the outermost to
the centre, on the right from the centre to the outermost. It takes every section for one of both sides.
"""

from copy import deepcopy
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gpsec.opendrive.road import Cubics

_SIDES = {"left": 1, "center": 0, "right": -1}
_POWERS = "abcd"
_SAME_STATION_M = 1e-6


def lane_number(lane: Element) -> int:
    """Return the id of a lane: left of the reference line positive, right negative."""
    return int(float(lane.get("id", "0")))


def order_lanes(root: Element) -> None:
    """Write the lanes of every section from left to right, each on the side that the sign of its id says."""
    for section in root.iterfind("road/lanes/laneSection"):
        lanes = sorted(section.iter("lane"), key=lane_number, reverse=True)
        for side in [item for item in section if item.tag in _SIDES]:
            section.remove(side)
        for side_name, sign in _SIDES.items():
            there = [lane for lane in lanes if np.sign(lane_number(lane)) == sign]
            if there:
                SubElement(section, side_name).extend(there)


def complete_sections(root: Element) -> int:
    """Give sections that hold for one side (``singleSide``) the lanes of the other one; return how many there were.

    The lanes that are not written go on as they are in the section before, so that they are written anew, with what
    changes along them from there on. Sections of both sides that begin at one station become one.
    """
    count = 0
    for lanes in root.iterfind("road/lanes"):
        former = None
        for section in sorted(lanes.findall("laneSection"), key=_station):
            single = section.attrib.pop("singleSide", "false") in ("true", "1")
            count += single
            if former is not None:
                distance = _station(section) - _station(former[0])
                if distance < _SAME_STATION_M and (single or former[1]):
                    _carry_on(former[0], section, 0.0)
                    lanes.remove(former[0])
                elif single:
                    _carry_on(former[0], section, distance)
            former = section, single
    return count


def _station(section: Element) -> float:
    return float(section.get("s", "0"))


def _carry_on(before: Element, section: Element, distance_m: float) -> None:
    """Write the lanes of the sides that a section does not have, as they are `distance_m` behind the one before."""
    for side_name in ("left", "right"):
        side = before.find(side_name)
        if side is None or section.find(f"{side_name}/lane") is not None:
            continue
        for empty in section.findall(side_name):
            section.remove(empty)
        copied = deepcopy(side)
        section.append(copied)
        if distance_m < _SAME_STATION_M:
            continue
        for old, new in zip(side.iter("lane"), copied.iter("lane"), strict=True):
            _cut_off(new, distance_m)
            _link(old, "successor", old.get("id", "0"))
            _link(new, "predecessor", old.get("id", "0"))


def _link(lane: Element, which: str, number: str) -> None:
    link = lane.find("link")
    if link is None:
        link = SubElement(lane, "link")
    for former in link.findall(which):
        link.remove(former)
    SubElement(link, which, id=number)


def _cut_off(lane: Element, distance_m: float) -> None:
    """Leave out what a lane has before a distance from the beginning of its section, and count from there on."""
    for tag in {item.tag for item in lane if item.get("sOffset") is not None}:
        items = sorted(lane.findall(tag), key=_offset)
        begun = [item for item in items if _offset(item) <= distance_m]
        for item in begun[:-1]:
            lane.remove(item)
        for item in begun[-1:]:
            if all(item.get(power) is not None for power in _POWERS):
                values = [float(item.get(power, "0")) for power in _POWERS]
                moved = Cubics.of([(_offset(item), *values)]).about(distance_m)
                item.attrib |= {power: repr(float(value)) for power, value in zip(_POWERS, moved, strict=True)}
            item.set("sOffset", "0")
        for item in items[len(begun) :]:
            item.set("sOffset", repr(_offset(item) - distance_m))


def _offset(item: Element) -> float:
    return float(item.get("sOffset", "0"))
