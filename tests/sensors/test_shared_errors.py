"""What receivers share: a common error, and places of multipath."""

from math import cos, exp, radians, sin

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.hdmap.map import compile_map
from gpsec.sensors.mismatch import Mismatch
from gpsec.sensors.multipath import drawn_multipath, scattered_multipath
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.testing.drive import Drive
from gpsec.types.drawn_zones import MULTIPATH_ZONE, DrawnZone
from tests.sensors.exact import profile

N = 1_000
SQUARE = np.array([[10.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0]])


def fixes(steps, seed=1, places=(), at=None, **gnss):
    """Return (steps, N, 2) fixes of vehicles that stand, with half of the slow error in common unless places are."""
    share = 0.0 if places else 0.5
    drive = Drive((profile(gnss=gnss or {"bias_m": 2.0, "bias_tau_s": 5.0}),), N, mismatch=Mismatch(common_share=share))
    if at is not None:
        drive.vehicles.rear_m[:] = at
    around = SharedErrors(drive.sensors, seed, places)
    state = around.new_state()
    found = []
    for step in range(steps):
        seen = drive.sense()
        around.disturb(state.now, drive.rows, step, drive.vehicles, seen)
        found.append(seen.fix_m.copy())
    return np.array(found)


def test_the_common_error_keeps_the_variance_and_correlates_vehicles():
    # 300 seeds, since a common error is one draw for a whole fleet.
    pairs = np.array([fixes(1, seed)[0, [0, 1], 0] for seed in range(300)])
    own = fixes(1)[0, :, 0]
    assert np.std(own) == pytest.approx(2.0 * np.sqrt(0.5), rel=0.1)  # what vehicles do not share
    assert np.var(pairs[:, 0] - pairs[:, 1]) < 1e-20 + np.var(pairs[:, 0]) * 1e-20  # the vehicles' own draws are kept
    assert np.var(pairs[:, 0]) == pytest.approx(2.0, rel=4.0 * np.sqrt(2.0 / 300))  # half of 2² is the common draw


def test_the_common_error_has_the_correlation_time_of_the_profile():
    common = fixes(3000, bias_m=1.0, bias_tau_s=2.0)[:, :, 1].mean(axis=1)
    assert np.corrcoef(common[:-10], common[10:])[0, 1] == pytest.approx(exp(-0.5), abs=0.12)


def test_the_common_error_depends_on_seed_and_step_alone():
    first, again, other = fixes(3), fixes(3), fixes(3, seed=2)
    np.testing.assert_array_equal(first, again)
    assert (first != other).all()


def test_a_fix_that_does_not_come_is_not_changed():
    steps = fixes(4, bias_m=1.0, rate_hz=5.0)
    held = (steps[1:] == steps[:-1]).all(axis=2)
    assert held.any(axis=0).all()


def zone(**parameters):
    return DrawnZone(
        "m", "polygon", SQUARE, {f"gpsec.{k}": v for k, v in parameters.items()}, "a.add.xml", MULTIPATH_ZONE
    )


def test_multipath_is_inside_its_polygon_alone():
    places = drawn_multipath([zone(error_m="0.5", direction_deg="30")], 1)
    at = np.random.default_rng(1).uniform(-10.0, 40.0, (N, 2))
    error = fixes(1, places=places, at=at, white_m=0.0)[0] - at
    inside = (at[:, 0] > 10.0) & (at[:, 0] < 20.0) & (at[:, 1] > 0.0) & (at[:, 1] < 10.0)
    vector = (0.5 * cos(radians(30.0)), 0.5 * sin(radians(30.0)))
    np.testing.assert_allclose(error[inside], np.tile(vector, (inside.sum(), 1)), atol=1e-9)
    np.testing.assert_allclose(error[~inside], 0.0, atol=1e-9)


def test_a_direction_that_is_not_stated_is_that_of_the_seed():
    one, again, other = (drawn_multipath([zone(error_m="0.5")], seed)[0].vector_m for seed in (1, 1, 2))
    assert np.hypot(*one) == pytest.approx(0.5)
    assert (one == again).all()
    assert (one != other).all()


@pytest.mark.parametrize(
    ("drawn", "says"),
    [
        (zone(), r"^a\.add\.xml: zone 'm': gpsec.error_m: expected a number from 0 to 100, found none"),
        (zone(error_m="much"), r"gpsec.error_m: expected a number, found 'much'"),
        (zone(error_m="-1"), r"gpsec.error_m: expected a number from 0 to 100, found -1"),
        (zone(error_m="1", direction_deg="400"), r"gpsec.direction_deg: expected a number from -360 to 360, found 400"),
        (
            DrawnZone("m", "point", SQUARE[:1], {}, "a.add.xml", MULTIPATH_ZONE),
            "expected a polygon for multipath, found a point",
        ),
        (DrawnZone("m", "polygon", SQUARE[[0, 2, 1, 3]], {}, "a.add.xml", MULTIPATH_ZONE), "does not cross itself"),
    ],
)
def test_a_zone_that_says_too_little_is_refused(drawn, says):
    with pytest.raises(GpsecError, match=says):
        drawn_multipath([drawn], 1)


def test_zones_of_attacks_are_none_of_multipath():
    assert drawn_multipath([DrawnZone("a", "polygon", SQUARE, {}, "a.add.xml")], 1) == []


@pytest.mark.parametrize("share", [0.12, 0.5, 1.0])
def test_scattered_multipath_holds_its_share_of_the_road(share, repository):
    lanes = compile_map(repository / "sumo_nets" / "town" / "town.net.xml", ()).lanes
    middle = np.stack([lanes.x0_m + 0.5 * lanes.length_m * lanes.dx, lanes.y0_m + 0.5 * lanes.length_m * lanes.dy], 1)
    short = lanes.length_m < 5.0  # a long segment lies in several squares
    place = scattered_multipath(lanes, share, 0.5, 25.0, 1)
    assert place is not None
    size_m = np.hypot(*place.error_m(middle).T)
    assert set(np.round(size_m, 9)) <= {0.0, 0.5}
    weight = lanes.length_m * short
    assert weight @ (size_m > 0.0) / weight.sum() == pytest.approx(share, abs=0.1)
    np.testing.assert_array_equal(place.error_m(np.array([[1e6, 1e6], [-1e6, -1e6]])), 0.0)


def test_scattered_multipath_of_no_road_is_none(repository):
    lanes = compile_map(repository / "sumo_nets" / "slow_curve" / "slow_curve.net.xml", ()).lanes
    assert scattered_multipath(lanes, 1e-9, 0.5, 1000.0, 1) is None
