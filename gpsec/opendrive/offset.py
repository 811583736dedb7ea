"""The heading in a header's offset, by which the whole map is turned: a net has none, so the map is turned itself.

OpenDRIVE 1.8, 8.5: world = turned by `hdg` about the map's origin, then moved by `x` and `y`.
"""

from math import cos, degrees, sin
from xml.etree.ElementTree import Element


def turn_map(root: Element) -> str:
    """Turn the roads of a map by the heading of its offset; return a sentence on it, or nothing."""
    offset = root.find("header/offset")
    heading_rad = 0.0 if offset is None else float(offset.get("hdg", "0"))
    if offset is None or heading_rad == 0.0:
        return ""
    ahead, left = cos(heading_rad), sin(heading_rad)
    for geometry in root.iterfind("road/planView/geometry"):
        x, y, heading = (float(geometry.get(key, "0")) for key in ("x", "y", "hdg"))
        geometry.set("x", repr(ahead * x - left * y))
        geometry.set("y", repr(left * x + ahead * y))
        geometry.set("hdg", repr(heading + heading_rad))
    offset.set("hdg", "0")
    return f"the header's offset has a heading: the map was turned by {degrees(heading_rad):.6g} degrees"
