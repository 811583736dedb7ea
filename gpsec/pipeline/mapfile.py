"""Writes `map.geojson`: lanes and drawn zones in WGS84, for the map of a report and for any GIS."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from gpsec.attacks.schedule import Plan
from gpsec.attacks.zones import Zone
from gpsec.core.arrays import Floats
from gpsec.core.geo import Projector
from gpsec.hdmap.map import HDMap
from gpsec.outcomes.geojson import FRAME, stated_frame
from gpsec.outcomes.tables import MAP, whole
from gpsec.sensors.multipath import Places

# Points of a lane that lie closer than this to the line through the others are left out.
_TOLERANCE_M = 0.1
# About a centimetre.
_DIGITS = 7
_CORNERS_OF_A_CIRCLE = 48


def write_map(folder: Path, hd_map: HDMap, plans: Sequence[Plan], places: Sequence[Places] = ()) -> None:
    """Write the lanes of the map, the zones of the plans and places of multipath as a GeoJSON collection (RFC 7946)."""
    lines = [hd_map.centre_line(lane) for lane in range(len(hd_map.lane_ids))]
    features = [
        _feature("LineString", line, {"kind": "lane", "id": lane_id, "internal": internal, "width_m": round(width, 3)})
        for line, lane_id, internal, width in zip(
            _projected(lines, hd_map.projector),
            hd_map.lane_ids,
            hd_map.sides.internal.tolist(),
            hd_map.sides.width_m.tolist(),
            strict=True,
        )
    ]
    drawn = [plan for plan in plans if plan.zone is not None and not plan.zone.moves]
    areas = [area for place in places for area in place.areas()]
    outlines = [_outline(plan.zone) for plan in drawn if plan.zone is not None]
    rings = _projected([*outlines, *(_ring(area.shape_m) for area in areas)], hd_map.projector)
    features += [
        _feature("Polygon", [ring], {"kind": "zone", "id": plan.config.name, "attack": plan.config.attack})
        for plan, ring in zip(drawn, rings[: len(drawn)], strict=True)
    ]
    features += [
        _feature("Polygon", [ring], {"kind": "multipath", "id": area.name, "error_m": round(area.size_m, 3)})
        for area, ring in zip(areas, rings[len(drawn) :], strict=True)
    ]
    with whole(folder / MAP) as partial:
        collection = {"type": "FeatureCollection", FRAME: stated_frame(hd_map.projector), "features": features}
        text = json.dumps(collection, separators=(",", ":"))
        partial.write_text(text + "\n", encoding="utf-8")


def _outline(zone: Zone) -> Floats:
    """Return the closed ring about a zone, counter-clockwise."""
    if zone.radius_m is None:
        return _ring(zone.shape_m)
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS_OF_A_CIRCLE + 1)
    ring: Floats = zone.shape_m[0] + zone.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring[-1] = ring[0]
    return ring


def _ring(shape_m: Floats) -> Floats:
    corners: Floats = shapely.get_coordinates(shapely.orient_polygons(shapely.Polygon(shape_m)))
    return corners


def _projected(lines: Sequence[Floats], projector: Projector) -> list[list[list[float]]]:
    """Return the longitudes and latitudes of lines, without points that they hardly need."""
    if not lines:
        return []
    counts = [len(line) for line in lines]
    thin = shapely.simplify(
        shapely.linestrings(np.concatenate(lines), indices=np.repeat(np.arange(len(lines)), counts)), _TOLERANCE_M
    )
    position_m, number = shapely.get_coordinates(thin, return_index=True)
    lon_lat = np.round(projector.to_lon_lat(position_m), _DIGITS)
    ends = np.flatnonzero(np.diff(number)) + 1
    return [part.tolist() for part in np.split(lon_lat, ends)]


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": kind, "coordinates": coordinates},
    }
