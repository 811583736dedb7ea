import numpy as np
import pytest

from gpsec.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession

KEYS = ["gpsec.attack", "gpsec.share", "gpsec.radius_m"]
POLYGON = '<poly id="z" type="gpsec.attack" shape="0,0 10,0 10,5"><param key="gpsec.attack" value="drift"/>{}</poly>'
POINT = '<poi id="p" type="gpsec.attack" x="3" y="4"><param key="gpsec.radius_m" value="50"/></poi>'
OTHERS = (
    '<poly id="house" type="building" shape="0,0 1,0 1,1"><param key="gpsec.nonsense" value="1"/></poly>'
    '<poi id="tree" x="1" y="1"/>'
)


@pytest.fixture
def zones(scenario):
    def read(additional):
        with SumoSession(resolve_options(scenario("", additional), seed=1), {}, lambda departure: True) as session:
            return session.zones(KEYS)

    return read


def test_zones_come_with_shape_and_parameters(zones):
    share = '<param key="gpsec.share" value="0.5"/><param key="note" value="mine"/>'
    polygon, point = zones(POLYGON.format(share) + POINT + OTHERS)
    assert (polygon.zone_id, polygon.kind) == ("z", "polygon")
    assert polygon.shape_m[:3].tolist() == [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]]
    assert polygon.parameters == {"gpsec.attack": "drift", "gpsec.share": "0.5"}
    assert (point.zone_id, point.kind) == ("p", "point")
    np.testing.assert_array_equal(point.shape_m, [[3.0, 4.0]])
    assert point.parameters == {"gpsec.radius_m": "50"}


def test_scenario_without_zones(zones):
    assert zones(OTHERS) == []


def test_unknown_parameter_of_a_zone_names_file_zone_and_nearest(zones):
    with pytest.raises(GpsecError, match=r"more.add.xml: zone 'z': .*'gpsec.shaer': did you mean 'gpsec.share'"):
        zones(POLYGON.format('<param key="gpsec.shaer" value="0.5"/>'))


def test_polygon_without_area_is_refused(zones):
    with pytest.raises(GpsecError, match="zone 'z': expected three corners"):
        zones('<poly id="z" type="gpsec.attack" shape="0,0 10,0"/>')
