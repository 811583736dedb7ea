"""The heading in a header's offset, by which the whole map is turned: a net has none, so the map is turned itself.

OpenDRIVE 1.8, 8.5: world = turned by `hdg` about the map's origin, then moved by `x` and `y`.
"""

from math import cos, degrees, isfinite, sin
from pathlib import Path
from xml.etree.ElementTree import Element

from gpsec.errors import GpsecError, shown


def turn_map(root: Element, map_file: Path) -> str:
    """Turn the roads of a map by the heading of its offset; return a sentence on it, or nothing.

    Args:
        root: of the map, whose roads have been read, so that what is in them are numbers.
        map_file: for what is said of errors.

    Raises:
        GpsecError: a value of the offset is no number.
    """
    offset = root.find("header/offset")
    if offset is None:
        return ""
    _, _, heading_rad = (_number(offset, key, map_file) for key in ("x", "y", "hdg"))
    if heading_rad == 0.0:
        return ""
    ahead, left = cos(heading_rad), sin(heading_rad)
    for geometry in root.iterfind("road/planView/geometry"):
        x, y, heading = (float(geometry.get(key, "0")) for key in ("x", "y", "hdg"))
        geometry.set("x", repr(ahead * x - left * y))
        geometry.set("y", repr(left * x + ahead * y))
        geometry.set("hdg", repr(heading + heading_rad))
    offset.set("hdg", "0")
    return f"the header's offset has a heading: the map was turned by {degrees(heading_rad):.6g} degrees"


def _number(offset: Element, key: str, map_file: Path) -> float:
    written = offset.get(key, "0")
    try:
        value = float(written)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise GpsecError(f"{map_file}: <offset> of the header: expected a number for '{key}', found '{shown(written)}'")
    return value
