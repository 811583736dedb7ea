"""Writes the map page as GeoJSON in WGS84, for QGIS and the like."""

import json
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.outcomes.tables import whole
from gpsec.running.results import Results

PLACES = "places.geojson"


def write_places(run: Results, path: Path | None = None) -> Path:
    """Write lanes, zones and what happened where as one collection (RFC 7946), and return its path."""
    features: list[dict[str, Any]] = []
    for stated in run.scenarios:
        for feature in run.map(stated["scenario"]):
            features.append(feature | {"properties": {"scenario": stated["scenario"]} | feature["properties"]})
    for row in run.places.astype(object).to_dict("records"):
        properties = {
            "scenario": row["scenario"],
            "kind": row["what"],
            "by": None if pd.isna(row["by"]) else row["by"],
            "attack": row["attack"],
            "vehicle_id": row["vehicle_id"],
            "profile": row["profile"],
            "time_s": round(row["time_s"], 3),
        }
        point = {"type": "Point", "coordinates": [row["lon_deg"], row["lat_deg"]]}
        features.append({"type": "Feature", "properties": properties, "geometry": point})
    target = path or run.folder / PLACES
    with whole(target) as partial:
        text = json.dumps({"type": "FeatureCollection", "features": features}, separators=(",", ":"))
        partial.write_text(text + "\n", encoding="utf-8")
    return target
