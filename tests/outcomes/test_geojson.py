"""The map of a run is read back whatever kinds of feature it has."""

import json

import pytest

from gpsec.core.errors import GpsecError
from gpsec.outcomes.geojson import read_features

RING = [[[10.0, 52.0], [10.1, 52.0], [10.1, 52.1], [10.0, 52.0]]]


def written(path, kind):
    feature = {"type": "Feature", "properties": {"kind": kind, "id": "a"}, "geometry": {"type": "Polygon"}}
    feature["geometry"]["coordinates"] = RING
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    return path


@pytest.mark.parametrize("kind", ["zone", "multipath"])
def test_polygons_are_zones_and_places_of_multipath(tmp_path, kind):
    (feature,) = read_features(written(tmp_path / "map.geojson", kind))
    assert feature["properties"]["kind"] == kind


def test_another_kind_is_refused(tmp_path):
    with pytest.raises(GpsecError, match="expected a GeoJSON collection"):
        read_features(written(tmp_path / "map.geojson", "tree"))
