"""The threshold: the kernel against its plain twin, and what passes."""

import numpy as np

from gpsec.imaging.pictures.threshold import NOT_LOOKED_AT, RidgeRows, over_threshold, ridges
from gpsec.reference.ridge import plain_ridge


def test_the_kernel_is_its_plain_twin():
    draw = np.random.default_rng(2)
    bright, yellow = draw.integers(0, 256, (2, 3, 60)).astype(np.uint8)
    columns = [np.array(values, np.int32) for values in ([0, 1, 3], [2, 4, 9], [1, 2, 6], [5, 0, 20], [50, 60, 45])]
    rows = RidgeRows(*columns)
    found = np.zeros((3, 60), np.int16)
    ridges(bright, yellow, rows, np.zeros((2, 61), np.int32), found)
    seen = 0
    for row in range(3):
        core, gap, flank = int(rows.core[row]), int(rows.gap[row]), int(rows.flank[row])
        for u in range(60):
            if max(rows.first[row], gap + flank) <= u < min(rows.last[row], 60 - gap - flank):
                expected = max(plain_ridge(channel[row], u, core, gap, flank) for channel in (bright, yellow))
                assert abs(found[row, u] - expected) <= 1.0
                seen += 1
            else:
                assert found[row, u] == NOT_LOOKED_AT
    assert seen > 60


def test_a_line_passes_and_the_road_does_not():
    draw = np.random.default_rng(3)
    found = draw.normal(-10.0, 16.0, (60, 300)).astype(np.int16)
    found[:, 150] = 1500
    passed = over_threshold(found) > 0
    assert passed[:, 150].all()
    assert passed.mean() < 0.01


def test_where_nothing_is_looked_at_nothing_is_found():
    assert not over_threshold(np.full((5, 5), NOT_LOOKED_AT, np.int16)).any()
