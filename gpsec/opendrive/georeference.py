"""Writes a geo-reference that PROJ and netconvert understand, and turns a map by the offset of its header."""

from math import cos, degrees, isfinite, sin
from xml.etree.ElementTree import Element, SubElement

import pyproj

from gpsec.opendrive.projection import projection, reference_system

_SAME_PLACE_M = 0.1
# Eastings of a UTM zone, with some room about it.
_UTM_M = (100_000.0, 900_000.0)


def set_georeference(root: Element, origin_deg: tuple[float, float] | None) -> str:
    """Write a usable geo-reference into the map's header; return a sentence on what was changed, or nothing.

    Args:
        root: of the map.
        origin_deg: latitude and longitude of the map's own origin, as the user gives it; it goes before the map's.
    """
    header = root.find("header")
    if header is None:
        header = Element("header")
        root.insert(0, header)
    reference = header.find("geoReference")
    written = " ".join((reference.text or "").split()) if reference is not None else ""
    found = projection(written, origin_deg)
    if reference is None:
        reference = SubElement(header, "geoReference")
    header.remove(reference)
    header.insert(0, reference)  # netconvert wants it before the offset
    for child in list(reference):
        reference.remove(child)
    reference.text = found.definition
    if found.replaced:
        for offset in header.findall("offset"):  # it belongs to the reference that was replaced
            header.remove(offset)
        return found.said
    turned = _mend_offset(root, header, found.definition)
    return "; ".join(filter(None, (found.said, turned, _beside(written, found.definition, root))))


def _beside(written: str, definition: str, root: Element) -> str:
    """Return a sentence on the distance between the map's place by the PROJ string and by the written reference."""
    crs, first = reference_system(written), root.find("road/planView/geometry")
    if "+proj=" in written or crs is None or first is None or crs.axis_info[0].unit_conversion_factor != 1.0:
        return ""
    offset = root.find("header/offset")
    shift = [float(offset.get(axis, "0")) if offset is not None else 0.0 for axis in "xy"]
    x, y = (float(first.get(axis, "0")) + away for axis, away in zip("xy", shift, strict=True))
    one, other = (
        pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True).transform(x, y)
        for system in (crs, pyproj.CRS(definition))
    )
    if not all(isfinite(value) for value in (*one, *other)):
        return ""
    metres = pyproj.Geod(ellps="WGS84").inv(*one, *other)[2]
    return f"that string lacks part of the datum and moves the map by {metres:.1f} m" if metres > _SAME_PLACE_M else ""


def _mend_offset(root: Element, header: Element, definition: str) -> str:
    """Turn the header's offset round where only that puts the map into its UTM zone; some programs write it so."""
    offset, first = header.find("offset"), root.find("road/planView/geometry")
    if offset is None or first is None or "+proj=utm" not in definition:
        return ""
    shift, x = float(offset.get("x", "0")), float(first.get("x", "0"))
    low, high = _UTM_M
    if low <= x + shift <= high or not low <= x - shift <= high:
        return ""
    for key in ("x", "y"):
        offset.set(key, f"{-float(offset.get(key, '0')):.4f}")
    return "geo-reference: the header's offset had the wrong sign for its UTM zone, and was turned round"


def turn_map(root: Element) -> str:
    """Turn the roads of a map by the heading of its header's offset; return a sentence on it, or nothing.

    A net has no such heading, so the map itself is turned. OpenDRIVE 1.8, 8.5: world = turned by `hdg` about the map's
    origin, then moved by `x` and `y`.
    """
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
