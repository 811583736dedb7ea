"""Truth on a spiral, whose curvature grows along the lane: a circle does not tell its two ends apart."""

from math import pi

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.types.vehicles import Vehicles

from .test_matching import place

LENGTH_M, POINTS_M = 100.0, 4.0
GROWTH = 5e-4  # of curvature, 1/m each metre: at its end the spiral has a radius of 20 m


def on_spiral(s_m: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, direction and curvature of a clothoid, its integral by small steps."""
    fine = np.linspace(0.0, LENGTH_M, 200_001)
    middle = 0.5 * (fine[1:] + fine[:-1])
    steps = np.exp(0.5j * side * GROWTH * middle**2) * (fine[1] - fine[0])
    line = np.concatenate([[0.0], np.cumsum(steps)])
    x, y = np.interp(s_m, fine, line.real), np.interp(s_m, fine, line.imag)
    return np.stack([x, y], axis=1), 0.5 * side * GROWTH * s_m**2, side * GROWTH * s_m


@pytest.fixture(scope="module", params=[1.0, -1.0])
def spiral(plain_net, request) -> tuple[HDMap, float]:
    points, _, _ = on_spiral(np.arange(0.0, LENGTH_M + 1e-9, POINTS_M), request.param)
    shape = " ".join(f"{x:.9f},{y:.9f}" for x, y in points)
    nodes = f'id="a" x="0" y="0"\nid="b" x="{points[-1, 0]:.9f}" y="{points[-1, 1]:.9f}"'
    edge = f'id="ab" from="a" to="b" speed="13.9" spreadType="center" shape="{shape}"'
    return compile_map(plain_net(nodes, edge), ()), request.param


@pytest.mark.parametrize("against", [False, True])
def test_curvature_and_direction_grow_along_a_segment(spiral, against):
    hd_map, side = spiral
    way = -1.0 if against else 1.0
    # Near both ends of segments, and not in the first and last, of which one end has no neighbour.
    at = (np.arange(3, 21)[:, None] * POINTS_M + np.array([0.4, 1.3, 2.7, 3.6])).ravel()
    position, yaw, curvature = on_spiral(at, side)
    vehicles = Table(Vehicles, len(at)).now
    vehicles.lane[:] = 0
    vehicles.rear_m[:] = position
    vehicles.yaw_rad[:] = yaw + (pi if against else 0.0)
    place(hd_map, vehicles)
    assert (vehicles.against == against).all()
    # The ends of a segment differ by 0.002 per metre; chords of 4 m account for less than a tenth of that.
    assert vehicles.camera_curvature_per_m == pytest.approx(way * curvature, abs=2e-4)
    turned = vehicles.lane_yaw_rad - vehicles.yaw_rad
    assert np.abs(np.sin(turned)).max() < 3e-3
    assert np.cos(turned).min() > 0.0
