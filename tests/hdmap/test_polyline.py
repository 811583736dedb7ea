from math import cos, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from gpsec.hdmap.polyline import CURVATURE_BASE_M, measure, resample


def circle(radius: float, step_rad: float, turn: float = pi / 2, left: float = 1.0) -> np.ndarray:
    angles = np.arange(0.0, turn + 1e-9, step_rad)
    return np.stack([radius * np.sin(angles), left * radius * (1.0 - np.cos(angles))], axis=1)


@pytest.mark.parametrize("left", [1.0, -1.0])
@pytest.mark.parametrize("radius", [12.0, 40.0, 600.0])
def test_circle(radius, left):
    step = 0.01
    line = measure(circle(radius, step, left=left))
    angles = step * np.arange(len(line.s_m))
    assert line.s_m == pytest.approx(2.0 * radius * sin(step / 2) * np.arange(len(angles)))
    # Symmetric points on a circle: the mean of two chords is the tangent, at the ends too.
    assert line.yaw_rad == pytest.approx(left * angles, abs=1e-9)
    # Angle by chord instead of by arc: 1/R · (h / sin h) with h half a step.
    expected = left / radius * (step / 2) / sin(step / 2)
    assert line.curvature_per_m == pytest.approx(np.full(len(angles), expected), rel=1e-9)


def test_curvature_of_a_clothoid_grows_with_its_length():
    rate, ds = 1e-3, 0.05
    s = np.arange(0.0, 60.0, ds)
    middle = 0.5 * rate * (s[:-1] + ds / 2) ** 2
    steps = ds * np.stack([np.cos(middle), np.sin(middle)], axis=1)
    line = measure(np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]))
    inside = (s > CURVATURE_BASE_M) & (s < s[-1] - CURVATURE_BASE_M)
    assert line.curvature_per_m[inside] == pytest.approx(rate * s[inside], abs=1e-4)


def test_yaw_is_unwrapped_over_the_back_direction():
    angles = np.linspace(0.9 * pi, 1.1 * pi, 50)
    steps = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    line = measure(np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]))
    assert abs(np.diff(line.yaw_rad)).max() < 0.1
    assert line.yaw_rad[-1] - line.yaw_rad[0] == pytest.approx(0.2 * pi, rel=0.05)


def test_one_segment_is_straight():
    line = measure(np.array([[1.0, 1.0], [4.0, 5.0]]))
    assert line.s_m.tolist() == [0.0, 5.0]
    assert line.yaw_rad == pytest.approx([0.927295218] * 2)
    assert line.curvature_per_m.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("radius", "spacing"), [(12.0, 2.0), (40.0, 5.0), (300.0, 10.0)])
def test_chords_of_a_resampled_circle_cut_it_by_s_squared_over_8_radius(radius, spacing):
    fine = measure(circle(radius, 0.0005))
    chords = resample(fine, spacing)
    step = chords.s_m[1]
    cut = max(shapely.LineString(chords.points_m).distance(shapely.Point(p)) for p in fine.points_m[::7])
    assert cut == pytest.approx(step**2 / (8.0 * radius), rel=0.01)
    assert spacing / 2 < step <= spacing


polylines = st.lists(
    st.tuples(st.floats(0.05, 30.0), st.floats(-0.6, 0.6)), min_size=1, max_size=30
)  # lengths and turns of its pieces


def build(pieces: list[tuple[float, float]]) -> np.ndarray:
    points, yaw = [np.zeros(2)], 0.0
    for length, turn in pieces:
        yaw += turn
        points.append(points[-1] + length * np.array([cos(yaw), sin(yaw)]))
    return np.array(points)


@given(polylines, st.floats(0.5, 20.0))
def test_resampled_points_lie_on_the_line_at_equal_distances(pieces, spacing):
    line = measure(build(pieces))
    stored = resample(line, spacing)
    whole = shapely.LineString(line.points_m)
    assert len(stored.points_m) - 1 == max(1, np.ceil(whole.length / spacing - 1e-9))
    assert stored.points_m[[0, -1]] == pytest.approx(line.points_m[[0, -1]])
    expected = [whole.interpolate(k / (len(stored.s_m) - 1), normalized=True) for k in range(len(stored.s_m))]
    assert stored.points_m == pytest.approx(np.array([[p.x, p.y] for p in expected]), abs=1e-8)
