"""Gives a map a geo-reference that PROJ, netconvert and gpsec understand."""

import re
from xml.etree.ElementTree import Element, SubElement

import pyproj

from gpsec.geo import DEFAULT_ORIGIN_DEG

# Heights are not used, and their grids are seldom installed.
_VERTICAL = r"\+(geoidgrids|vunits|vto_meter)=\S+"
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
    definition, said = _definition(written, origin_deg)
    if reference is None:
        reference = SubElement(header, "geoReference")
    header.remove(reference)
    header.insert(0, reference)  # netconvert wants it before the offset
    for child in list(reference):
        reference.remove(child)
    reference.text = definition
    if said and said != _HEIGHTS:
        for offset in header.findall("offset"):  # it belongs to the reference that was replaced
            header.remove(offset)
        return said
    return "; ".join(filter(None, (said, _mend_offset(root, header, definition))))


_HEIGHTS = "heights were left out of the geo-reference"


def _definition(written: str, origin_deg: tuple[float, float] | None) -> tuple[str, str]:
    """Return a projection that can be used, and what was changed against the one that is written."""
    if origin_deg is not None:
        return _about(*origin_deg), f"geo-reference: set to {_place(*origin_deg)}, as --origin says"
    if "+proj=" in written and _usable(written):
        return written, ""
    flat = re.sub(_VERTICAL, "", written)
    if "+proj=" in flat and _usable(flat):
        return " ".join(flat.split()), _HEIGHTS
    stated = [re.search(rf"\+{key}=(-?[\d.]+(?:e[+-]?\d+)?)", written) for key in ("lat_0", "lon_0")]
    if stated[0] and stated[1]:
        place = float(stated[0][1]), float(stated[1][1])
        if abs(place[0]) <= 90.0 and abs(place[1]) <= 180.0:
            return _about(*place), f"geo-reference: had no projection; {_place(*place)}, its lat_0 and lon_0"
    lon, lat = DEFAULT_ORIGIN_DEG
    what = "is none that PROJ knows" if written else "is missing"
    return _about(lat, lon), f"geo-reference: {what}; {_place(lat, lon)} by default, set another with --origin"


def _about(lat: float, lon: float) -> str:
    return f"+proj=tmerc +lat_0={lat:.12g} +lon_0={lon:.12g} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def _place(lat: float, lon: float) -> str:
    return f"a transverse Mercator projection about {lat:g}, {lon:g}"


def _usable(definition: str) -> bool:
    try:
        transformer = pyproj.Transformer.from_crs("EPSG:4326", pyproj.CRS(definition), always_xy=True)
        transformer.transform(0.0, 0.0, direction="INVERSE")
    except pyproj.exceptions.ProjError:
        return False
    return True


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
