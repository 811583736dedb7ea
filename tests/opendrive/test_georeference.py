"""A header's heading turns the map."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.hdmap.net import read_net
from gpsec.opendrive.georeference import turn_map
from gpsec.opendrive.importing import import_map
from gpsec.opendrive.read import parse

from .maps import LINE, document, lane, road, section, write

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
