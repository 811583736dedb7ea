import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession

KEYS = {
    "gpsec.attack": ["gpsec.attack", "gpsec.share", "gpsec.radius_m"],
    "gpsec.multipath": ["gpsec.error_m", "gpsec.direction_deg"],
}
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
    assert polygon.file.endswith("/more.add.xml")
    assert point.file == polygon.file
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
    with pytest.raises(GpsecError, match=r"/more.add.xml: zone 'z': expected three corners"):
        zones('<poly id="z" type="gpsec.attack" shape="0,0 10,0"/>')


@pytest.mark.parametrize(
    "name", ["old town", "a&lt;b", "a'b", "a,b", "a;b", "a|b", "a\\b", "a&quot;b", "a&amp;b", "a&#62;b"]
)
@pytest.mark.parametrize(
    "zone",
    ['<poly id="{}" type="gpsec.attack" shape="0,0 10,0 10,5"/>', '<poi id="{}" type="gpsec.attack" x="3" y="4"/>'],
)
def test_zone_whose_id_sumo_does_not_take_is_refused(zones, name, zone):
    with pytest.raises(GpsecError, match=r"more.add.xml: po(ly|i) '.*' is of type .* expected an id without blanks"):
        zones(POINT + zone.format(name))


def test_zone_that_stands_among_the_routes_is_refused(scenario):
    config = scenario('<poly id="z" type="gpsec.attack" shape="0,0 10,0 10,5"/>')
    with (
        SumoSession(resolve_options(config, seed=1), {}, lambda departure: True) as session,
        pytest.raises(GpsecError, match=r"cars.rou.xml: poly 'z' is of type .*: expected it in an additional file"),
    ):
        session.zones(KEYS)


def test_zone_in_an_included_file_is_refused_by_the_name_of_that_file(zones, tmp_path):
    included = tmp_path / "zones.xml"
    included.write_text('<additional><poly id="old town" type="gpsec.attack" shape="0,0 10,0 10,5"/></additional>')
    with pytest.raises(GpsecError, match=r"zones.xml: poly 'old town'"):
        zones(f'<include href="{included}"/>')


def test_zone_in_an_included_file_knows_that_file(zones, tmp_path):
    included = tmp_path / "zones.xml"
    included.write_text(f"<additional>{POINT}</additional>")
    polygon, point = zones(f'{POLYGON.format("")}<include href="{included}"/>')
    assert polygon.file.endswith("/more.add.xml")
    assert point.file == str(included)


def test_zones_of_multipath_come_with_their_own_parameters(zones):
    drawn = '<poly id="m" type="gpsec.multipath" shape="0,0 10,0 10,5"><param key="gpsec.{}" value="0.5"/></poly>'
    [zone] = zones(drawn.format("error_m"))
    assert (zone.zone_type, zone.parameters) == ("gpsec.multipath", {"gpsec.error_m": "0.5"})
    with pytest.raises(GpsecError, match=r"zone 'm': unknown parameter 'gpsec.eror_m': did you mean 'gpsec.error_m'"):
        zones(drawn.format("eror_m"))
    with pytest.raises(GpsecError, match=r"zone 'm': unknown parameter 'gpsec.share'"):
        zones(drawn.format("share"))


@pytest.mark.parametrize("tag", ["poly", "poi"])
def test_zone_of_an_unknown_type_is_refused(zones, tag):
    where = 'shape="0,0 10,0 10,5"' if tag == "poly" else 'x="1" y="1"'
    with pytest.raises(GpsecError, match=rf"{tag} 'z': unknown type 'gpsec.multpath': did you mean 'gpsec.multipath'"):
        zones(f'<{tag} id="z" type="gpsec.multpath" {where}/>')


def test_other_polygons_may_be_called_what_they_are_called(zones):
    [zone] = zones('<poly id="old town" type="building" shape="0,0 1,0 1,1"/>' + POINT)
    assert zone.zone_id == "p"
