"""The map of a run is read back whatever kinds of feature it has."""

import json

import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.geo import Projector
from gpsec.outcomes.geojson import FRAME, read_features, read_frame, stated_frame

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


def test_the_frame_of_the_net_is_read_back(tmp_path):
    frame = Projector("+proj=utm +zone=32 +datum=WGS84 +units=m", (-600_000.0, -5_790_000.0))
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({FRAME: stated_frame(frame), "features": []}))
    assert read_frame(path) == frame


@pytest.mark.parametrize("stated", [None, {}, {"definition": "+proj=nothing", "offset_m": [0, 0]}, {"definition": "!"}])
def test_a_map_that_does_not_say_its_frame_has_none(tmp_path, stated):
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({FRAME: stated, "features": []}))
    assert read_frame(path) is None
