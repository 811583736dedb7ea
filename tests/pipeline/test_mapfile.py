import json
from dataclasses import dataclass

import numpy as np
import pytest
import shapely

from gpsec.attacks.zones import Zone
from gpsec.hdmap.map import load_map
from gpsec.outcomes.tables import MAP
from gpsec.pipeline.mapfile import write_map
from gpsec.sensors.multipath import drawn_multipath, scattered_multipath
from gpsec.types.drawn_zones import MULTIPATH_ZONE, DrawnZone


@dataclass(frozen=True)
class Config:
    name: str
    attack: str = "drift"


@dataclass(frozen=True)
class DrawnPlan:
    config: Config
    zone: Zone | None


@pytest.fixture(scope="module")
def hd_map(repository):
    return load_map(repository / "sumo_nets" / "town" / "town.net.xml", (1.0,))


@pytest.fixture(scope="module")
def features(hd_map, tmp_path_factory):
    plans = [
        DrawnPlan(Config("everywhere"), None),
        DrawnPlan(Config("square"), Zone("square", np.array([[0.0, 0.0], [0.0, 9.0], [9.0, 9.0], [9.0, 0.0]]))),
        DrawnPlan(Config("mast"), Zone("mast", np.array([[100.0, 50.0]]), 30.0)),
    ]
    folder = tmp_path_factory.mktemp("map")
    corners = np.array([[200.0, 0.0], [200.0, 9.0], [209.0, 9.0], [209.0, 0.0]])
    canyon = DrawnZone("canyon", "polygon", corners, {"gpsec.error_m": "0.5"}, "f", MULTIPATH_ZONE)
    scattered = scattered_multipath(hd_map.lanes, 0.05, 0.3, 50.0, 1)
    write_map(folder, hd_map, plans, [*drawn_multipath([canyon], 1), scattered])
    return json.loads((folder / MAP).read_text("utf-8"))["features"]


def net_frame(hd_map, coordinates):
    return hd_map.projector.from_lon_lat(np.array(coordinates))


def test_every_lane_is_there_to_a_decimetre(hd_map, features):
    lanes = [feature for feature in features if feature["properties"]["kind"] == "lane"]
    assert [lane["properties"]["id"] for lane in lanes] == list(hd_map.lane_ids)
    for number in range(0, len(lanes), 40):
        line = shapely.LineString(net_frame(hd_map, lanes[number]["geometry"]["coordinates"]))
        assert line.hausdorff_distance(shapely.LineString(hd_map.centre_line(number))) < 0.15


def test_zones_are_closed_rings_counter_clockwise(hd_map, features):
    square, mast = (feature for feature in features if feature["properties"]["kind"] == "zone")
    assert square["properties"] == {"kind": "zone", "id": "square", "attack": "drift"}
    for zone, area_m2 in ((square, 81.0), (mast, np.pi * 30.0**2)):
        ring = zone["geometry"]["coordinates"][0]
        assert ring[0] == ring[-1]
        polygon = shapely.Polygon(net_frame(hd_map, ring))
        assert polygon.exterior.is_ccw
        assert polygon.area == pytest.approx(area_m2, rel=0.01)


def test_places_of_multipath_are_rings_with_the_size_of_their_error(hd_map, features):
    canyon, *squares = (feature for feature in features if feature["properties"]["kind"] == "multipath")
    assert canyon["properties"] == {"kind": "multipath", "id": "canyon", "error_m": 0.5}
    assert shapely.Polygon(net_frame(hd_map, canyon["geometry"]["coordinates"][0])).area == pytest.approx(
        81.0, rel=0.01
    )
    place = scattered_multipath(hd_map.lanes, 0.05, 0.3, 50.0, 1)
    assert len({square["properties"]["id"] for square in squares}) == len(squares) > 3
    for square in squares:
        ring = shapely.Polygon(net_frame(hd_map, square["geometry"]["coordinates"][0]))
        assert ring.area == pytest.approx(2500.0, rel=0.01)
        middle = np.array([[ring.centroid.x, ring.centroid.y]])
        assert np.hypot(*place.error_m(middle)[0]) == pytest.approx(square["properties"]["error_m"])
