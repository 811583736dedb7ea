"""Left-hand traffic: netconvert sees the map in a mirror, in which traffic keeps right, and the net is mirrored back.

netconvert does not read on which side a map's traffic keeps. Its own option for left-hand traffic changes lanes over
after they have been laid out, which puts those of a road with a lane offset or a median in the wrong place.
"""

from xml.etree.ElementTree import Element

from gpsec.opendrive.netfile import ORIGINAL
from gpsec.opendrive.road import Road

# What changes its sign when north becomes south.
_MIRRORED = {
    "geometry": ("y", "hdg"),
    "arc": ("curvature",),
    "spiral": ("curvStart", "curvEnd"),
    "poly3": ("a", "b", "c", "d"),
    "paramPoly3": ("aV", "bV", "cV", "dV"),
    "laneOffset": ("a", "b", "c", "d"),
    "superelevation": ("a", "b", "c", "d"),
}
_OTHER_SIDE = {"left": "right", "right": "left"}
_OTHER_TURN = {"l": "r", "r": "l", "L": "R", "R": "L"}


def map_keeps_left(roads: list[Road]) -> bool:
    """Return whether traffic keeps left on the greater part of the map."""
    return sum(road.length_m if road.left_hand else -road.length_m for road in roads) > 0.0


def mirror_map(root: Element) -> None:
    """Turn north into south; left lanes become right ones."""
    for element in root.iter():
        for key in _MIRRORED.get(element.tag, ()):
            if element.get(key) is not None:
                element.set(key, repr(-float(element.get(key, "0"))))
        if element.tag == "laneSection":
            _mirror_lanes(element)
        elif element.tag == "laneLink":
            _negate(element, "from")
            _negate(element, "to")
        elif element.tag == "validity":
            first, last = element.get("fromLane", "0"), element.get("toLane", "0")
            element.attrib |= {"fromLane": str(-int(last)), "toLane": str(-int(first))}


def _mirror_lanes(section: Element) -> None:
    for side in section:
        side.tag = _OTHER_SIDE.get(side.tag, side.tag)
    for lane in section.iter("lane"):
        _negate(lane, "id")
        for link in (*lane.iterfind("link/predecessor"), *lane.iterfind("link/successor")):
            _negate(link, "id")


def _negate(element: Element, key: str) -> None:
    element.set(key, str(-int(float(element.get(key, "0")))))


def mirror_net(net: Element) -> None:
    """Turn south into north again in the net that netconvert made of a mirrored map."""
    net.set("lefthand", "true")
    for element in net.iter():
        if element.get("shape"):
            element.set("shape", " ".join(_mirrored(corner) for corner in element.get("shape", "").split()))
        if element.tag == "junction":
            element.set("y", f"{-float(element.get('y', '0')):.4f}")
        elif element.tag == "connection":
            turn = element.get("dir", "s")
            element.set("dir", _OTHER_TURN.get(turn, turn))
        elif element.tag == "location":
            west, south, east, north = element.get("convBoundary", "0,0,0,0").split(",")
            element.set("convBoundary", ",".join((west, _opposite(north), east, _opposite(south))))
        elif element.tag == "param" and element.get("key") == ORIGINAL:
            road, _, lane = element.get("value", "").rpartition("_")
            element.set("value", f"{road}_{-int(lane)}")


def _mirrored(corner: str) -> str:
    x, y, *z = corner.split(",")
    return ",".join((x, _opposite(y), *z))


def _opposite(number: str) -> str:
    return number[1:] if number.startswith("-") else f"-{number}"
