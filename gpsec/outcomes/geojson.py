"""Reads the map of a run, which anybody may have edited."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.core.geo import Projector

# Member of the collection that says which frame the net has, beyond RFC 7946.
FRAME = "frame"
# Geometry of each kind of feature, and the fewest points of its lines.
_GEOMETRIES = {"lane": ("LineString", 2), "zone": ("Polygon", 3), "multipath": ("Polygon", 3)}


def read_features(path: Path) -> list[dict[str, Any]]:
    """Return the features of a map: lanes and zones, in WGS84; none where there is no map.

    Raises:
        GpsecError: it is no collection of these.
    """
    try:
        document = json.loads(path.read_text("utf-8"))
        json.dumps(document, ensure_ascii=False).encode()  # no lone surrogates: no page can hold them
        features: list[dict[str, Any]] = document["features"]
        whole = isinstance(features, list) and all(map(_is_feature, features))
    except FileNotFoundError:
        return []
    except OSError as error:
        raise GpsecError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, LookupError, TypeError, OverflowError, RecursionError):
        whole = False
    if not whole:
        raise GpsecError(f"{path}: expected a GeoJSON collection of lanes and zones, found another file")
    return features


def stated_frame(projector: Projector) -> dict[str, Any]:
    """Return the frame of a net as plain JSON, for `FRAME`."""
    return {"definition": projector.definition, "offset_m": list(projector.offset_m)}


def read_frame(path: Path) -> Projector | None:
    """Return the frame of the net that a map is of; None where it does not say, as those of older versions."""
    try:
        stated = json.loads(path.read_text("utf-8"))[FRAME]
        definition, (east_m, north_m) = stated["definition"], stated["offset_m"]
        projector = Projector(str(definition), (float(east_m), float(north_m)), str(path))
        projector.to_lon_lat(np.zeros((1, 2)))
    except (OSError, ValueError, LookupError, TypeError, RecursionError, GpsecError):
        return None
    return projector


def _is_feature(feature: Any) -> bool:
    properties, geometry = feature["properties"], feature["geometry"]
    kind, points = _GEOMETRIES[properties["kind"]]
    lines = [geometry["coordinates"]] if kind == "LineString" else geometry["coordinates"]
    return (
        isinstance(feature, dict)
        and geometry["type"] == kind
        and isinstance(properties["id"], str)
        and isinstance(lines, list)
        and len(lines) > 0
        and all(_is_line(line, points) for line in lines)
    )


def _is_line(line: Any, points: int) -> bool:
    places = np.array(line)
    return (
        places.dtype.kind in "if"
        and places.ndim == 2
        and places.shape[0] >= points
        and places.shape[1] == 2
        and bool((np.abs(places) <= [180.0, 90.0]).all())  # False for NaN
    )
