"""Rewrites or leaves out what makes netconvert fail, on a copy of an OpenDRIVE map."""

from math import isfinite
from xml.etree.ElementTree import Element, SubElement

from gpsec.opendrive.read import SHORTEST_ROAD_M

# What netconvert asks for, and must not be empty; it gives up a map for one signal without it.
_OF_SIGNAL = ("id", "type", "orientation", "dynamic")
_OF_REFERENCE = ("id", "orientation")
_OF_VALIDITY = ("fromLane", "toLane")
# Less than netconvert and the evaluator differ by.
_SAME_PLACE_M = 1e-5


def simplify(root: Element) -> list[str]:
    """Leave out or rewrite what would make netconvert give up the map; return what was done, one sentence each.

    Objects beside the road are left out without a word, since a net has none.
    """
    for road in root.iterfind("road"):
        for objects in road.findall("objects"):
            road.remove(objects)
        if road.find("lanes/laneSection") is None:
            _give_section(road)
    unusable = _drop_signals(root)
    links = _drop_links(root)
    curves = sum(_plainer(geometry) for geometry in root.iterfind("road/planView/geometry"))
    said = [
        (unusable, "signals without an id, a type, an orientation or a place, left out"),
        (links, "links to roads that are not on the map, left out"),
        (curves, "spirals of constant curvature and arcs without one, written as arcs and lines"),
    ]
    return [f"{what}: {count}" for count, what in said if count]


def _give_section(road: Element) -> None:
    """Give a road without lane sections one without lanes: netconvert crashes where another one leads to it."""
    lanes = road.find("lanes")
    section = SubElement(SubElement(road, "lanes") if lanes is None else lanes, "laneSection", s="0")
    SubElement(SubElement(section, "center"), "lane", id="0", type="none")


def _drop_links(root: Element) -> int:
    """Take out links to roads that are not there; return how many."""
    roads = {road.get("id", "") for road in root.iterfind("road")}
    count = 0
    for link in root.iterfind("road/link"):
        for end in [end for end in link if end.get("elementType") == "road" and end.get("elementId") not in roads]:
            link.remove(end)
            count += 1
    for junction in root.iterfind("junction"):
        for way in junction.findall("connection"):
            if any(way.get(key, "") not in roads for key in ("incomingRoad", "connectingRoad") if way.get(key)):
                junction.remove(way)
                count += 1
    return count


def _drop_signals(root: Element) -> int:
    """Take out the signals that netconvert cannot read, and references to signals that are not there."""
    groups = root.findall("road/signals")
    count = sum(_drop(group, "signal", _OF_SIGNAL, None) for group in groups)
    known = {signal.get("id", "") for group in groups for signal in group.iterfind("signal")}
    return count + sum(_drop(group, "signalReference", _OF_REFERENCE, known) for group in groups)


def _drop(group: Element, tag: str, needed: tuple[str, ...], known: set[str] | None) -> int:
    bad = [
        signal
        for signal in group.findall(tag)
        if not all(signal.get(key) for key in needed)
        or not _is_number(signal.get("s"))
        or (known is not None and signal.get("id") not in known)
        or not all(_is_whole(item.get(key)) for item in signal.iterfind("validity") for key in _OF_VALIDITY)
    ]
    for signal in bad:
        group.remove(signal)
    return len(bad)


def _is_number(written: str | None) -> bool:
    try:
        return written is not None and isfinite(float(written))
    except ValueError:
        return False


def _is_whole(written: str | None) -> bool:
    return written is not None and written.strip().lstrip("+-").isascii() and written.strip().lstrip("+-").isdigit()


def _plainer(geometry: Element) -> bool:
    """Replace a spiral of constant curvature by an arc, and an arc without curvature by a line.

    netconvert divides by the change of a curvature and by the curvature itself: it loses such a road, or fills the
    memory with points that are all the same.
    """
    length = float(geometry.get("length", "0"))
    spiral, arc = geometry.find("spiral"), geometry.find("arc")
    shape = spiral if spiral is not None else arc
    if length <= SHORTEST_ROAD_M or shape is None:
        return False
    ends = [float(shape.get(key, "0")) for key in (("curvature",) if spiral is None else ("curvStart", "curvEnd"))]
    # The end of the arc of the mean curvature lies beside that of the spiral by change · length² / 12.
    if abs(ends[-1] - ends[0]) * length**2 / 12.0 > _SAME_PLACE_M:
        return False
    curvature = sum(ends) / len(ends)
    straight = abs(curvature) * length**2 / 2.0 <= _SAME_PLACE_M
    if spiral is None and not straight:
        return False
    geometry.remove(shape)
    geometry.insert(0, Element("line") if straight else Element("arc", curvature=repr(curvature)))
    return True
