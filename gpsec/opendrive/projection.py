"""The projection that a geo-reference means, as a PROJ string, which is all that netconvert reads."""

import re
import warnings
from math import inf
from typing import NamedTuple

import pyproj
from pyproj.transformer import TransformerGroup

from gpsec.core.errors import shown
from gpsec.core.geo import DEFAULT_ORIGIN_DEG

# Heights are not used, and their grids are seldom installed.
_VERTICAL = r"\+(geoidgrids|vunits|vto_meter)=\S+"
_UNITS = r"\+(units|to_meter)=\S+"
# A code, a PROJ string, WKT or PROJJSON.
_FORMAL = re.compile(r"\w+:\S+$|\d+$|\+|\w+\[|\{")


class Projection(NamedTuple):
    """A projection that can be used, what was changed against the written one, and whether it is another one."""

    definition: str
    said: str = ""
    replaced: bool = False


def projection(written: str, origin_deg: tuple[float, float] | None) -> Projection:
    """Return the projection that a map's reference means, or one about its origin, which goes before it.

    Args:
        written: the geo-reference, empty where there is none.
        origin_deg: latitude and longitude of the map's own origin, as the user gives it.
    """
    if origin_deg is not None:
        return Projection(_about(*origin_deg), f"geo-reference: set to {_place(*origin_deg)}, as --origin says", True)
    if "+proj=" in written and _usable(written):
        return _metric(Projection(written), written)
    flat = " ".join(re.sub(_VERTICAL, "", written).split())
    if "+proj=" in flat and _usable(flat):
        return _metric(Projection(flat, "heights were left out of the geo-reference"), flat)
    known = _known(written)
    if known and _usable(known):
        return _metric(Projection(known, f"geo-reference: '{shown(written)}' is written as {known}"), written)
    stated = [re.search(rf"\+{key}=(-?[\d.]+(?:e[+-]?\d+)?)", written) for key in ("lat_0", "lon_0")]
    if stated[0] and stated[1]:
        place = _degrees(stated[0][1]), _degrees(stated[1][1])
        if abs(place[0]) <= 90.0 and abs(place[1]) <= 180.0:
            said = f"geo-reference: had no projection; {_place(*place)}, its lat_0 and lon_0"
            return Projection(_about(*place), said, True)
    lon, lat = DEFAULT_ORIGIN_DEG
    said = f"geo-reference: {_fault(written)}; {_place(lat, lon)} by default, set another with --origin"
    return Projection(_about(lat, lon), said, True)


def _metric(found: Projection, written: str) -> Projection:
    """Return a projection in metres, which is what OpenDRIVE's coordinates are in, and say where `written` is not."""
    crs = reference_system(written)
    unit = crs.axis_info[0] if crs is not None and crs.axis_info else None
    if unit is None or unit.unit_conversion_factor == 1.0:
        return found
    definition = " ".join(f"{re.sub(_UNITS, '', found.definition)} +units=m".split())
    name = unit.unit_name if unit.unit_name != "unknown" else f"units of {unit.unit_conversion_factor:g} m"
    said = f"geo-reference: is in {name}, the map was taken in metres, as OpenDRIVE has it; convert a map that is not"
    return Projection(definition, "; ".join(filter(None, (found.said, said))))


def _fault(written: str) -> str:
    crs = reference_system(written)
    if crs is None:
        return "is none that PROJ knows" if written else "is missing"
    return "is in degrees, where a map is in metres" if crs.is_geographic else "is none of a flat map"


def _degrees(written: str) -> float:
    try:
        return float(written)
    except ValueError:  # such as 1.2.3
        return inf


def _known(written: str) -> str:
    """Return the PROJ string of a projection that is given by a code, as WKT or by its name; "" where it is none."""
    crs = reference_system(written)
    if crs is None or not crs.is_projected:
        return ""
    with warnings.catch_warnings():
        # A string does not say all that a code does, and grids are not installed; see `georeference._beside`.
        warnings.simplefilter("ignore", UserWarning)
        try:
            definition = crs.to_proj4().replace(" +type=crs", "")
        except pyproj.exceptions.ProjError:  # there are projections that no string can say
            return ""
        steps = TransformerGroup(crs, "EPSG:4326", always_xy=True).transformers[:1]
    definition = re.sub(_UNITS, "+units=m", definition)
    if "+datum=" in definition or "+towgs84=" in definition:
        return definition
    shifts = [step.towgs84 for way in steps for step in way.operations or () if any(step.towgs84)]
    return f"{definition} +towgs84={','.join(f'{value:.10g}' for value in shifts[0])}" if shifts else definition


def reference_system(written: str) -> pyproj.CRS | None:
    """Return the horizontal reference system that a code, a WKT or a name means, None where PROJ knows none."""
    try:
        crs = pyproj.CRS(written)
    except pyproj.exceptions.ProjError:
        return None
    crs = crs.sub_crs_list[0] if crs.is_compound else crs
    # Of other words, PROJ takes whatever one system has in its name.
    return crs if _FORMAL.match(written) or crs.name.casefold() == written.casefold() else None


def _about(lat: float, lon: float) -> str:
    return f"+proj=tmerc +lat_0={lat:.12g} +lon_0={lon:.12g} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def _place(lat: float, lon: float) -> str:
    return f"a transverse Mercator projection about {lat:g}, {lon:g}"


def _usable(definition: str) -> bool:
    try:
        crs = pyproj.CRS(definition)
        if crs.is_geographic or crs.is_geocentric:  # in degrees, or about the centre of the Earth
            return False
        transformer = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True)
        transformer.transform(0.0, 0.0, direction="INVERSE")
    except pyproj.exceptions.ProjError:
        return False
    return True
