"""The paint of nets that were made for it."""

import numpy as np
import pytest

from gpsec.core.tables import taken
from gpsec.hdmap.map import compile_map
from gpsec.imaging.pictures.paint import PAINT_ERROR_M, SURFACE, WHITE_PAINT, YELLOW_PAINT, paint_roads

# Three lanes of 3.2 m to the east, and a road with a bend that one can turn into.
THREE_LANES = (
    'id="a" x="0" y="0"\nid="b" x="1000" y="0"',
    'id="ab" from="a" to="b" numLanes="3" width="3.2" speed="33.3"',
)
TURN = (
    'id="a" x="0" y="0"\nid="b" x="100" y="0"\nid="c" x="100" y="100"\nid="d" x="200" y="0"',
    'id="ab" from="a" to="b" speed="13.9"\nid="bc" from="b" to="c" speed="13.9"\nid="bd" from="b" to="d" speed="13.9"',
)


@pytest.fixture(scope="module")
def motorway(plain_net):
    return compile_map(plain_net(*THREE_LANES), ())


def lines(ground, kind):
    """Middle and width of the cross sections of a kind."""
    chosen = taken(ground.strips, ground.strips.kind == kind)
    middle = 0.5 * (chosen.left_m + chosen.right_m)
    return middle, np.hypot(*(chosen.left_m - chosen.right_m).T), chosen


def test_lines_lie_on_the_boundaries_of_lanes(motorway):
    ground = paint_roads(motorway, 1)
    yellow, width, _ = lines(ground, YELLOW_PAINT)
    white, _, _ = lines(ground, WHITE_PAINT)
    right, left = motorway.centre_line(0)[0, 1] - 1.6, motorway.centre_line(2)[0, 1] + 1.6
    assert np.abs(yellow[:, 1] - left).max() < 4.0 * PAINT_ERROR_M
    np.testing.assert_allclose(width, 0.15)
    boundaries = right + 3.2 * np.arange(3)
    assert np.abs(white[:, 1:] - boundaries).min(axis=1).max() < 4.0 * PAINT_ERROR_M
    _, wide, _ = lines(ground, SURFACE)
    assert (wide > 3.2).all()


def test_the_paint_is_not_the_map(motorway):
    off = lines(paint_roads(motorway, 1), YELLOW_PAINT)[0][:, 1]
    assert np.std(off) == pytest.approx(PAINT_ERROR_M, rel=0.4)
    other = lines(paint_roads(motorway, 2), YELLOW_PAINT)[0][:, 1]
    assert not np.allclose(off, other)
    np.testing.assert_array_equal(off, lines(paint_roads(motorway, 1), YELLOW_PAINT)[0][:, 1])


def test_dashes_are_a_quarter_of_their_line(motorway):
    middle, _, strips = lines(paint_roads(motorway, 1), WHITE_PAINT)
    first = motorway.centre_line(0)[0, 1] + 1.6
    dashes = np.abs(middle[:, 1] - first) < 0.5
    painted = sum(
        np.ptp(middle[dashes & (strips.strip == number), 0]) for number in np.unique(strips.strip[dashes]).tolist()
    )
    assert painted / 1000.0 == pytest.approx(3.05 / 12.19, rel=0.05)


def test_a_stop_line_lies_before_turns_alone(motorway, plain_net):
    def across(hd_map):
        strips = lines(paint_roads(hd_map, 1), WHITE_PAINT)[2]
        return int((np.hypot(*(strips.left_m - strips.right_m).T) > 1.0).sum())

    assert across(motorway) == 0
    assert across(compile_map(plain_net(*TURN), ())) == 2  # two cross sections of one line


def test_wear_is_between_nothing_and_all(motorway):
    wear = lines(paint_roads(motorway, 1), YELLOW_PAINT)[2].wear
    assert 0.0 <= wear.min() < 0.35
    assert 0.65 < wear.max() <= 1.0
