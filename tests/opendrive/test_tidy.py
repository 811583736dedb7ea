"""Lanes without extent get one, in the direction of the lanes that they join."""

import math

import pytest

from gpsec.opendrive.tidy import SHORTEST_LANE_M, give_extent

NET = """<net>
<edge id="a"><lane id="a_0" index="0" shape="0.00,0.00 10.00,0.00"/></edge>
<edge id="b"><lane id="b_0" index="0" shape="{behind}"/></edge>
<edge id=":n"><lane id=":n_0" index="0" shape="10.00,0.00 10.00,0.00"/></edge>
<connection from="a" to="b" fromLane="0" toLane="0" via=":n_0"/>
</net>"""


@pytest.mark.parametrize(
    ("behind", "ahead"),
    [
        ("10.00,0.00 20.00,0.00", (1.0, 0.0)),
        ("10.00,0.00 0.00,0.00", (-1.0, 0.0)),
        ("10.00,0.00 10.00,10.00", (0.5, 0.5)),
    ],
)
def test_lane_without_extent_gets_a_direction(behind: str, ahead: tuple[float, float]) -> None:
    text = NET.format(behind=behind)
    shape = '10.00,0.00 10.00,0.00"/></edge>'
    x, y = (0.5 * SHORTEST_LANE_M * part / math.hypot(*ahead) for part in ahead)
    expected = f"{10.0 - x:.4f},{-y:.4f} {10.0 + x:.4f},{y:.4f}".replace("-0.0000", "0.0000")
    assert give_extent(text).replace("-0.0000", "0.0000") == text.replace(shape, f'{expected}"/></edge>')
