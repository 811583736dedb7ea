"""Geo-references become projections in metres, and the heading of a header turns the map."""

import re
from math import pi
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pyproj
import pytest

from gpsec.core.errors import GpsecError
from gpsec.hdmap.net import read_net
from gpsec.opendrive import projection
from gpsec.opendrive.georeference import set_georeference, turn_map
from gpsec.opendrive.importing import import_map
from gpsec.opendrive.read import parse

from .maps import LINE, TMERC, TWO_WAY, document, lane, road, section, write

EAST = LINE.replace('x="0"', 'x="10"').replace('y="0"', 'y="20"')


def offset(**values: str) -> str:
    written = " ".join(f'{key}="{value}"' for key, value in values.items())
    return f"<offset {written}/>"


def test_net_lies_where_the_offset_puts_it(tmp_path: Path) -> None:
    # Turned by 90 degrees about the origin, a road from (10, 20) eastwards begins at (-20, 10) and runs north.
    header = offset(x="1000", y="2000", z="0", hdg=f"{pi / 2}")
    source = write(tmp_path, document(road(section("", lane(-1, 3.0)), EAST), header=header))
    done = import_map(
        source, tmp_path / "map.net.xml", origin_deg=None, alarm_m={}, overwrite=False, tell=lambda stage: None
    )
    net = read_net(done.net)
    (shape,) = (item.shape_m for item in net.lanes if not item.internal)
    assert shape[[0, -1]] == pytest.approx(np.array([[-18.5, 10.0], [-18.5, 110.0]]), abs=1e-3)
    assert done.check.overall.unmatched_share == 0.0
    assert any("turned by 90 degrees" in sentence for sentence in done.mended)
    # The map's own origin lies 1 km east and 2 km north of the projection's.
    lon, lat = net.projector.to_lon_lat(np.zeros(2))
    assert (lon, lat) == (pytest.approx(10.0 + 1000.0 / 68_678.0, abs=2e-5), pytest.approx(52.01797, abs=2e-5))


@pytest.mark.parametrize("values", [{"x": "5", "y": "6"}, {"x": "5", "y": "6", "hdg": "0.0"}])
def test_without_a_heading_nothing_turns(tmp_path: Path, values: dict[str, str]) -> None:
    root = parse(write(tmp_path, document(road("", EAST), header=offset(**values))))
    assert turn_map(root) == ""
    assert [item.get("x") for item in root.iter("geometry")] == ["10"]


@pytest.mark.parametrize("key", ["x", "y", "hdg"])
def test_offset_that_is_no_number_is_refused(tmp_path: Path, key: str) -> None:
    header = offset(**{"x": "5", "y": "6", "hdg": "0", key: "far"})
    source = write(tmp_path, document(road("", EAST), header=header))
    with pytest.raises(GpsecError, match=rf"map\.xodr: header: <offset>: expected a number .* '{key}', found 'far'$"):
        parse(source)


def reference(folder: Path, written: str | None, origin: tuple[float, float] | None = None) -> tuple[str, str, Element]:
    root = parse(write(folder, document(road(TWO_WAY), reference=written)))
    said = set_georeference(root, origin)
    return root.findtext("header/geoReference", ""), said, root


def test_usable_reference_stays(tmp_path: Path) -> None:
    assert reference(tmp_path, TMERC)[:2] == (TMERC, "")


@pytest.mark.parametrize(
    ("written", "origin", "place", "says"),
    [
        ("+lat_0=4.9e+1 +lon_0=8", None, "+lat_0=49 +lon_0=8 ", "no projection"),
        (None, None, "+lat_0=52.2647 +lon_0=10.5268 ", "is missing"),
        ("+proj=longlat +datum=WGS84", None, "+lat_0=52.2647 +lon_0=10.5268 ", "is in degrees"),
        ("EPSG:4326", None, "+lat_0=52.2647 +lon_0=10.5268 ", "is in degrees"),
        ("LOCAL", None, "+lat_0=52.2647 +lon_0=10.5268 ", "none that PROJ knows"),
        (TMERC, (-33.9, 151.2), "+lat_0=-33.9 +lon_0=151.2 ", "--origin"),
    ],
)
def test_other_references_become_a_projection(
    tmp_path: Path, written: str | None, origin: tuple[float, float] | None, place: str, says: str
) -> None:
    definition, said, _ = reference(tmp_path, written, origin)
    assert definition.startswith("+proj=tmerc")
    assert place in definition
    assert says in said


UTM_WKT = (
    'PROJCS["here",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]'
)


@pytest.mark.parametrize(
    "written",
    ["EPSG:32632", "epsg:25832", "urn:ogc:def:crs:EPSG::25832", "EPSG:25832+7837", "WGS 84 / UTM zone 32N", UTM_WKT],
)
def test_references_in_other_words_are_written_as_proj_strings(tmp_path: Path, written: str) -> None:
    header = '<offset x="600000" y="5800000" z="0" hdg="0"/>'
    root = parse(write(tmp_path, document(road(TWO_WAY), reference=written, header=header)))
    said = set_georeference(root, None)
    definition = root.findtext("header/geoReference", "")
    assert "+proj=" in definition
    assert "is written as +proj=" in said
    # On its central meridian, 9 degrees east, a quarter of the meridian (10,001,965.729 m) is shortened to 0.9996.
    zone = pyproj.Transformer.from_crs(definition, "EPSG:4326", always_xy=True)
    assert zone.transform(500000.0, 0.0) == pytest.approx((9.0, 0.0), abs=1e-9)
    assert zone.transform(500000.0, 0.9996 * 10001965.729)[1] == pytest.approx(90.0, abs=1e-7)
    assert root.find("header/offset") is not None  # it belongs to this reference


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("+proj=tmerc +lat_0=40 +lon_0=-74 +x_0=300000 +datum=WGS84 +units=us-ft +no_defs", "US survey foot"),
        ("+proj=tmerc +lat_0=40 +lon_0=-74 +x_0=300000 +datum=WGS84 +to_meter=0.3048", "foot"),
        ("+proj=tmerc +lat_0=40 +lon_0=-74 +x_0=300000 +datum=WGS84 +to_meter=0.5", "units of 0.5 m"),
        ("EPSG:2263", "US survey foot"),
    ],
)
def test_a_reference_in_feet_is_taken_in_metres_and_said(tmp_path: Path, written: str, unit: str) -> None:
    definition, said, _ = reference(tmp_path, written)
    assert f"geo-reference: is in {unit}, the map was taken in metres" in said
    place = pyproj.Transformer.from_crs(definition, "EPSG:4326", always_xy=True)
    # The false easting is 300 km; a kilometre further north is one further from there, and not 0.3.
    (lon, lat), (_, north) = place.transform(300000.0, 0.0), place.transform(300000.0, 1000.0)
    assert lon == pytest.approx(-74.0, abs=1e-9)
    assert pyproj.Geod(ellps="WGS84").inv(lon, lat, lon, north)[2] == pytest.approx(1000.0, rel=1e-3)


def test_datum_of_a_code_is_kept(tmp_path: Path) -> None:
    definition, said, _ = reference(tmp_path, "EPSG:31467")
    place = 3500000.0, 5500000.0
    one, other = (
        pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True).transform(*place)
        for system in ("EPSG:31467", definition)
    )
    # Bessel's ellipsoid taken for WGS 84's would lie 150 m away.
    assert pyproj.Geod(ellps="WGS84").inv(*one, *other)[2] < 0.1
    assert "datum" not in said


def test_datum_that_no_string_bears_is_said(tmp_path: Path) -> None:
    geometry = '<geometry s="0" x="500000" y="6250000" hdg="0" length="100"><line/></geometry>'
    root = parse(write(tmp_path, document(road(TWO_WAY, geometry), reference="EPSG:20256")))  # AGD66, Sydney
    found = re.search(r"moves the map by ([\d.]+) m$", set_georeference(root, None))
    assert found is not None
    one, other = (
        pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True).transform(500000.0, 6250000.0)
        for system in ("EPSG:20256", root.findtext("header/geoReference", ""))
    )
    assert float(found[1]) == pytest.approx(pyproj.Geod(ellps="WGS84").inv(*one, *other)[2], abs=0.1)


def test_heights_are_left_out_where_their_grid_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # As PROJ does, where it knows of a grid that is not installed.
    monkeypatch.setattr(projection, "_usable", lambda definition: "geoidgrids" not in definition)
    definition, said, _ = reference(tmp_path, "+proj=utm +zone=32 +datum=WGS84 +geoidgrids=egm96_15.gtx +vunits=m")
    assert definition == "+proj=utm +zone=32 +datum=WGS84"
    assert "heights" in said


@pytest.mark.parametrize(("x", "turned"), [(-500000.0, True), (500000.0, False)])
def test_offset_that_leads_out_of_the_zone_is_turned_round(tmp_path: Path, x: float, turned: bool) -> None:
    header = f'<offset x="{x}" y="{x * 10}" z="0" hdg="0"/>'
    root = parse(write(tmp_path, document(road(TWO_WAY), reference="+proj=utm +zone=32 +datum=WGS84", header=header)))
    said = set_georeference(root, None)
    offset = root.find("header/offset")
    assert offset is not None
    assert (float(offset.get("x", "0")), float(offset.get("y", "0"))) == (500000.0, 5000000.0)
    assert bool(said) == turned
